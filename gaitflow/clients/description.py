"""Which description (URDF) belongs to a map's robot: where it is, how the robot stands in it, how its feet touch."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, files
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.config.file import ConfigError
from gaitflow.core.trajectory import Array
from gaitflow.motion import Frames
from gaitflow.urdf.contact import collision_spheres
from gaitflow.urdf.description import Description, read_description
from gaitflow.urdf.mechanism import Mechanism, load_mechanism
from gaitflow.urdf.pose import find_srdf, is_written, pose_of

PACKAGE = "example-robot-data"
SMALL_RADIUS = 0.01  # m, of a foot that has no collision sphere
SAME_POINT = 1e-4  # m
SAME_PLACE = 0.01  # m: a robot made left-right symmetric moves its feet by less
SAME_MASS = 0.01  # relative


@dataclass(frozen=True, eq=False)
class Foot:
    """The ball on which a leg stands: its leg's name, its link, and its centre [3] m in the link's frame.

    standing [3] m is that centre, seen from the link's origin (which is the plan's foot), along the base's axes while
    the robot stands.
    """

    leg: str
    link: str
    centre: Array
    radius: float
    standing: Array


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """A robot's URDF, and what ties plans to it: frames, the pose in which it stands (joint: rad), its feet by leg."""

    urdf: Description
    frames: Frames
    pose: Mapping[str, float]
    feet: tuple[Foot, ...]

    @property
    def depth(self) -> float:
        """How far the ground lies below the plan's, which passes through the origins of the feet's links [m]."""
        return float(np.mean([foot.radius - foot.standing[2] for foot in self.feet]))


def describe(scenario: Mapping[str, Any], urdf: Path | None = None) -> RobotDescription:
    """The description of the robot in a map's scenario, JSON data: at a path, or the one that the robot was made from.

    The latter is looked for in the package example-robot-data. Raises ConfigError: a robot without frames, no URDF
    found, one that cannot be read, or one of another robot.
    """
    robot = scenario["robot"]
    frames = Frames.of(scenario)
    if frames is None:
        raise ConfigError(
            f"the robot {robot['name']} has no frames, so nobody knows its links: import it from its URDF by `gaitflow "
            "robot import` and publish the map anew"
        )
    description = read_description(_installed(robot) if urdf is None else urdf)
    mechanism = load_mechanism(description)
    _check_links(mechanism, frames)
    own = mechanism.joints_of([foot.link for foot in frames.feet])
    asked = _pose_name(robot)
    srdf = None if is_written(asked) else find_srdf(description)
    angles = pose_of(asked, mechanism, [joint for joints in own for joint in joints], srdf).angles
    _check_body(mechanism, angles, robot, frames)
    return RobotDescription(
        urdf=description,
        frames=frames,
        pose=dict(zip(mechanism.joint_names, angles.tolist(), strict=True)),
        feet=tuple(
            _foot(description, each.leg, each.link, np.array(each.contact_point), mechanism, angles)
            for each in frames.feet
        ),
    )


def _installed(robot: Mapping[str, Any]) -> Path:
    """Where the URDF that a robot's source names is installed."""
    label = str(robot.get("source", "")).partition(",")[0]
    if not (label.startswith(f"{PACKAGE}/") and label.endswith(".urdf")):
        raise ConfigError(
            f"the robot {robot['name']} does not say which URDF it was made from: give its path by --urdf"
        )
    try:
        listed = files(PACKAGE) or []
    except PackageNotFoundError:
        raise ConfigError(
            f"{label}: {PACKAGE} is not installed: give the URDF's path by --urdf, or pip install {PACKAGE}"
        ) from None
    for file in listed:
        if str(file).endswith(f"share/{label}"):
            return Path(str(file.locate()))
    raise ConfigError(f"{label}: not in the {PACKAGE} that is installed: give the URDF's path by --urdf")


def _pose_name(robot: Mapping[str, Any]) -> str | None:
    """The pose that a robot was imported in, as `pose_of` takes it; None where its source does not say."""
    found = re.search(r", pose (.+?), base level", str(robot.get("source", "")))
    return found[1] if found else None


def _check_links(mechanism: Mechanism, frames: Frames) -> None:
    try:
        for link in (frames.base_link, *(foot.link for foot in frames.feet)):
            mechanism.link(link)
    except ConfigError as error:
        raise ConfigError(f"a URDF whose feet do not match those of the map: {error}") from None


def _check_body(mechanism: Mechanism, angles: Array, robot: Mapping[str, Any], frames: Frames) -> None:
    if abs(mechanism.mass - robot["mass"]) > SAME_MASS * robot["mass"]:
        raise ConfigError(
            f"{mechanism.label}: weighs {mechanism.mass:.3f} kg, the map's robot {robot['name']} {robot['mass']:.3f} "
            "kg: give the URDF that the robot was imported from"
        )
    for foot, leg in zip(frames.feet, robot["legs"], strict=True):
        wanted = np.array(leg["default_foot"]) + frames.com_in_base
        found, _ = mechanism.point(mechanism.link(foot.link), angles)
        if np.linalg.norm(found - wanted) > SAME_PLACE:
            raise ConfigError(
                f"{mechanism.label}: a URDF whose feet do not match those of the map: standing, {foot.link} is at "
                f"{np.round(found, 3).tolist()} m in the base's frame, in the map at {np.round(wanted, 3).tolist()} m"
            )


def _foot(description: Description, leg: str, link: str, contact: Array, mechanism: Mechanism, angles: Array) -> Foot:
    """The collision sphere that touches the ground at the contact point; a small one there where there is none."""
    rotation = mechanism.rotation(mechanism.link(link), angles)
    spheres = collision_spheres(description, link)
    touching = [(c, r) for c, r in spheres if abs(float(np.linalg.norm(contact - c)) - r) < SAME_POINT]
    up = rotation.T @ np.array([0.0, 0.0, 1.0])
    centre, radius = touching[0] if touching else (contact + SMALL_RADIUS * up, SMALL_RADIUS)
    return Foot(leg, link, centre, radius, rotation @ centre)
