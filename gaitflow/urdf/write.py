"""A robots YAML as people read it: one field a line with its unit, and the command that made it."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import yaml

from gaitflow.config.frames import Frames
from gaitflow.config.limbs import Limb
from gaitflow.config.robot import Robot
from gaitflow.files import new_file


def robot_text(robot: Robot, comments: Iterable[str]) -> str:
    """The YAML text of a robot; `load_robot` reads exactly this robot back. `comments` are its first lines.

    What cannot be printed, such as a line break in a file's name, is escaped in them.
    """
    lines = [f"# {_printable(line)}" for line in comments]
    lines += [
        f"name: {_word(robot.name)}",
        f"dimension: {robot.dimension}",
        f"mass: {_number(robot.mass)}  # kg",
        "inertia:  # kg m^2 about the centre of mass",
        *(f"  - {_vector(row)}" for row in robot.inertia),
        "legs:  # feet in the base frame at the centre of mass, m",
        *(f"  - {{name: {_word(leg.name)}, default_foot: {_vector(leg.default_foot)}}}" for leg in robot.legs),
        f"box: {_vector(robot.box)}  # m, half lengths around each default foot",
        f"max_force: {_number(robot.max_force)}  # N, normal force of one foot",
        f"max_foot_speed: {_number(robot.max_foot_speed)}  # m/s, along each axis",
        f"max_tilt: {_number(robot.max_tilt)}  # rad, along each angle",
        f"mirror: [{', '.join(f'[{_word(left)}, {_word(right)}]' for left, right in robot.mirror)}]",
        f"source: {json.dumps(robot.source)}",
        *_frames(robot.frames),
        *_limbs(robot.limbs),
    ]
    return "\n".join(lines) + "\n"


def write_robot(path: Path, robot: Robot, comments: Iterable[str], *, replace: bool) -> None:
    """Write a robots YAML as a whole. Raises FileExistsError unless `replace`, and WriteError."""
    with new_file(path, replace=replace) as file:
        file.write(robot_text(robot, comments).encode())


def _frames(frames: Frames | None) -> list[str]:
    if frames is None:
        return []
    return [
        "frames:  # of the description; in a standing pose, m",
        f"  base_link: {_word(frames.base_link)}",
        f"  com_in_base: {_vector(frames.com_in_base)}  # centre of mass in the base link's frame",
        "  feet:  # the link whose origin is the foot, and where it touches the ground in the link's frame",
        *(
            f"    - {{leg: {_word(foot.leg)}, link: {_word(foot.link)}, contact_point: {_vector(foot.contact_point)}}}"
            for foot in frames.feet
        ),
    ]


def _limbs(limbs: Iterable[Limb] | None) -> list[str]:
    if limbs is None:
        return []
    lines = ["limbs:  # how legs are built; m, in the base frame at the centre of mass, and kg m^2"]
    for limb in limbs:
        lines += [
            f"  - leg: {_word(limb.leg)}",
            f"    hip: {_vector(limb.hip)}  # x of the flexion axis, y and z of the abduction axis",
            f"    aside: {_number(limb.aside)}  # the leg's plane, from the abduction axis to the left",
            f"    below: {_number(limb.below)}  # the flexion axis, under the abduction axis in that plane",
            f"    thigh: {_number(limb.thigh)}",
            f"    shank: {_number(limb.shank)}",
            f"    knee: {limb.knee}",
            f"    mass: {_number(limb.mass)}  # kg",
            f"    abduction_inertia: {_number(limb.abduction_inertia)}  # of the leg, standing",
            f"    flexion_inertia: [{', '.join(map(_vector, limb.flexion_inertia))}]  # about hip flexion and knee",
        ]
    return lines


def _number(value: float) -> str:
    """Shortest text that reads back as this float; never with an exponent, which YAML takes for text without a dot."""
    return np.format_float_positional(value, trim="0")


def _vector(values: Iterable[float]) -> str:
    return f"[{', '.join(map(_number, values))}]"


def _printable(text: str) -> str:
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


def _word(name: str) -> str:
    """A name, in quotes where YAML would read something else, as in NO."""
    try:
        plain = yaml.safe_load(f"[{name}]") == [name]
    except yaml.YAMLError:
        plain = False
    return name if plain else json.dumps(name)
