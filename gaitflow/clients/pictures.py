"""A walk as the scene that `gaitflow.report` draws."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.robot_model import PHYSICS_STEP, RobotModel
from gaitflow.clients.rotation import rotation_of
from gaitflow.clients.walking import Frame
from gaitflow.core.layout import GRAVITY
from gaitflow.motion import Motion
from gaitflow.report.walk_scene import WalkScene

THICKNESS = 0.2  # of the drawn body, as a share of its height above the ground


class Filmed(Protocol):
    """What was filmed: frames 30 a second, and which feet touched after each ms [n, legs]."""

    @property
    def frames(self) -> Sequence[Frame]:
        """The frames, from the start."""

    @property
    def touching(self) -> NDArray[np.bool_]:
        """The feet that touched."""


def scene_of_walk(robot: RobotModel, motion: Motion, walk: Filmed) -> WalkScene:
    """The scene of a robot's walk that followed a motion. The drawn body spans the legs' first joints."""
    first = walk.frames[0]
    rotations = np.array([rotation_of(frame.orientation) for frame in walk.frames])
    hips = (first.points[:, 0] - first.position) @ rotations[0]
    low, high = hips.min(axis=0), hips.max(axis=0)
    middle = (low[2] + high[2]) / 2
    low[2], high[2] = middle - THICKNESS / 2 * robot.height, middle + THICKNESS / 2 * robot.height
    corners = np.array([[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)])
    positions = np.array([frame.position for frame in walk.frames])
    return WalkScene(
        times=np.array([frame.time for frame in walk.frames]),
        middle=positions,
        body=positions[:, None] + corners @ rotations.transpose(0, 2, 1),
        legs=np.array([frame.points for frame in walk.frames]),
        forces=np.array([frame.forces for frame in walk.frames]) / (robot.mass * GRAVITY),
        ground=robot.ground,
        height=robot.height,
        leg_names=motion.leg_names,
        touching=walk.touching,
        step=PHYSICS_STEP,
        planned=tuple(motion.pattern.split("/")),
        durations=motion.trajectory.durations,
    )
