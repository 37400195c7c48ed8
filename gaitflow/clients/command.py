"""The body's commanded motion at any time, which all gaits at one task share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.trajectory import Array
from gaitflow.core.twist import displacements, headings, velocities
from gaitflow.motion import Motion

SAMPLES = 40  # of a cycle


@dataclass(frozen=True, eq=False)
class Commanded:
    """A level body at n times: centre of mass [n, 3] m, heading [n] rad and its rate rad/s, velocity [n, 3] m/s.

    The height is that of standing. In the world frame of the motion.
    """

    position: Array
    heading: Array
    velocity: Array
    yaw_rate: float


def commanded(motion: Motion, times: Array) -> Commanded:
    """What the task of a motion commands at times [n] s, through the middle of where the motion's first cycle is.

    Raises ValueError for a motion in the plane and for one that gains speed.
    """
    task = motion.task
    if motion.dimension != 3 or task["acceleration"] != 0:
        raise ValueError("a commanded body is in space and keeps its speed: ask for acceleration = 0")
    cycle = np.arange(SAMPLES) * motion.period / SAMPLES
    middle = (motion.of_mass().sample(cycle).position[:, :2] - displacements(task, cycle)).mean(axis=0)
    position, velocity = np.zeros((2, len(times), 3))
    position[:, :2] = displacements(task, times) + middle
    position[:, 2] = -RigidBody.of(motion.scenario["robot"], task).default_feet[:, 2].mean()
    velocity[:, :2] = velocities(task, times)
    return Commanded(position, headings(task, times), velocity, task["yaw_rate"])
