"""From a URDF to the single rigid body of the paper (section III.A), with what was found on the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from gaitflow.config.file import ConfigError
from gaitflow.config.robot import Robot
from gaitflow.core.layout import GRAVITY
from gaitflow.core.names import leg_place
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.contact import contact_point
from gaitflow.urdf.description import Description, read_description
from gaitflow.urdf.limbs import limbs_of
from gaitflow.urdf.limits import max_foot_speed, max_vertical_force
from gaitflow.urdf.mechanism import Array, load_mechanism
from gaitflow.urdf.pose import find_srdf, is_written, pose_of
from gaitflow.urdf.reach import check_box, check_reach, default_box, longest_reach
from gaitflow.urdf.symmetry import symmetrised

QUADRUPED = ("LF", "RF", "LH", "RH")
DIGITS = 6  # of what is written: micrometres, milligrams


@dataclass(frozen=True)
class Request:
    """What to import: a URDF, the links that are feet and, in their order, the legs' names; None: found or computed."""

    urdf: Path
    name: str
    feet: tuple[str, ...]
    legs: tuple[str, ...] | None = None
    pose: str | None = None
    srdf: Path | None = None
    inertia: Literal["composite", "base"] = "composite"
    box: tuple[float, float, float] | None = None  # half lengths [m]
    max_force: float | None = None  # [N]
    max_foot_speed: float | None = None  # [m/s]
    max_tilt: float = 0.5  # [rad]


@dataclass(frozen=True)
class Imported:
    """A robot and what a person should know of how it came about, a sentence each."""

    robot: Robot
    found: tuple[str, ...]


def import_robot(request: Request) -> Imported:
    """The robot that a URDF describes, in space, left-right symmetric, with a kinematic box that its legs reach.

    Raises ConfigError that names the thing and the way out.
    """
    names = _leg_names(request)
    urdf = read_description(request.urdf)
    mechanism = load_mechanism(urdf)
    own_joints = mechanism.joints_of(request.feet)
    srdf = None if request.srdf is None else read_description(request.srdf)
    if srdf is None and not is_written(request.pose):
        srdf = find_srdf(urdf)
    pose = pose_of(request.pose, mechanism, [joint for own in own_joints for joint in own], srdf)
    legs = [
        LegChain(mechanism, name, mechanism.link(foot), own, pose.angles)
        for name, foot, own in zip(names, request.feet, own_joints, strict=True)
    ]
    check_reach(legs)
    centre, composite = mechanism.composite(pose.angles)
    feet = np.array([leg.foot_at(leg.stance)[0] - centre for leg in legs])
    _check_sides(names, request.feet, feet)
    inertia = composite if request.inertia == "composite" else mechanism.base_inertia()
    body = symmetrised(feet, inertia, names)
    found = [
        f"{urdf.label}, {pose.label}, base level",
        "inertia of the whole robot about its centre of mass"
        if request.inertia == "composite"
        else "inertia of the base link alone, about its own centre of mass; mass of the whole robot",
        f"made left-right symmetric: feet moved by up to {body.foot_offset * 1e3:.2f} mm, "
        f"Ixy = {_digits(body.products[0]):g} and Iyz = {_digits(body.products[1]):g} kg m^2 set to 0",
    ]
    box, said = _box(request, legs, body.feet + centre)
    found.append(said)
    force, said = _limit(request.max_force, "N from effort limits", lambda: max_vertical_force(legs))
    found.append(f"max_force {said}")
    held, weight = force * len(legs), mechanism.mass * GRAVITY
    if held < weight:
        found.append(
            f"it cannot stand: {len(legs)} feet hold {held:.0f} N together, less than its weight of {weight:.0f} N; "
            "is the unit of the effort limits N m, and is --max-force for one foot?"
        )
    speed, said = _limit(request.max_foot_speed, "m/s from velocity limits", lambda: max_foot_speed(legs))
    found.append(f"max_foot_speed {said}")
    contacts = [_contact(urdf, foot, leg) for foot, leg in zip(request.feet, legs, strict=True)]
    if any(contact is None for contact in contacts):
        found.append("a foot has no collision sphere: where its link's origin is it touches the ground")
    limbs = limbs_of(legs, centre, body.feet, body.pairs)
    if limbs is None:
        found.append("legs are not built of hip abduction, hip flexion and knee: no objective of energy")
    robot = {
        "name": request.name,
        "dimension": 3,
        "mass": _digits(mechanism.mass),
        "inertia": _rounded(body.inertia),
        "legs": [{"name": n, "default_foot": foot} for n, foot in zip(names, _rounded(body.feet), strict=True)],
        "box": box.tolist(),
        "max_force": force,
        "max_foot_speed": speed,
        "max_tilt": request.max_tilt,
        "mirror": [[names[left], names[right]] for left, right in body.pairs],
        "source": "; ".join(found),
        "frames": {
            "base_link": mechanism.base_link,
            "com_in_base": [_digits(value) for value in centre],
            "feet": [
                {"leg": name, "link": foot, "contact_point": contact or [0.0, 0.0, 0.0]}
                for name, foot, contact in zip(names, request.feet, contacts, strict=True)
            ],
        },
    } | ({} if limbs is None else {"limbs": limbs})
    return Imported(Robot.from_data(robot, f"robot {request.name}"), tuple(found))


def _contact(urdf: Description, foot: str, leg: LegChain) -> list[float] | None:
    """Where a foot touches the ground [3] m, in its link's frame; None where the URDF does not say."""
    point = contact_point(urdf, foot, leg.mechanism.rotation(leg.foot, leg.pose))
    return None if point is None else [_digits(value) for value in point]


def _leg_names(request: Request) -> tuple[str, ...]:
    """One name a foot. Raises ConfigError."""
    names = request.legs or QUADRUPED
    if len(set(request.feet)) != len(request.feet):
        raise ConfigError(f"--feet {','.join(request.feet)}: each link once")
    if len(names) != len(request.feet):
        raise ConfigError(
            f"--feet names {len(request.feet)} links, --legs {','.join(names)} has {len(names)}: give a leg's name for "
            "each foot, in the same order"
        )
    return names


def _check_sides(names: Sequence[str], links: Sequence[str], feet: Array) -> None:
    """Legs must stand below the body and where their names say (see `leg_place`). feet [legs, 3] m."""
    places = {name: leg_place(name) for name in names}
    # Without a front leg, R is no rear: RL is then a right leg.
    placed = any(place is not None and place[0] > 0 for place in places.values())
    for name, link, foot in zip(names, links, feet, strict=True):
        where = f"({', '.join(f'{value:.3g}' for value in foot)}) m from the centre of mass"
        if foot[2] >= 0:
            raise ConfigError(f"foot {link} is at {where}, not below it: the base link's z must point up")
        expected = places[name] if placed else None
        if expected and tuple(np.sign(foot[:2])) != expected:
            raise ConfigError(
                f"foot {link} is at {where}, which is no place for leg {name}: x points forward and y to the left; "
                f"list --feet in the order of the legs {','.join(names)}, or turn the base link"
            )


def _box(request: Request, legs: Sequence[LegChain], centres: Array) -> tuple[Array, str]:
    """The box asked for, or one that fits; what to say of it. centres [legs, 3] m in the base link's frame."""
    if request.box is not None:
        box = np.array(request.box)
        check_box(legs, centres, box)
        return box, "box as asked for, within reach of every leg"
    box, part = default_box(legs, centres)
    reach = min(longest_reach(leg) for leg in legs)
    return box, f"box of ANYmal's proportions at {part:.0%} of its size for a leg of {reach:.3f} m, within reach"


def _limit(asked: float | None, source: str, compute: Callable[[], float]) -> tuple[float, str]:
    if asked is not None:
        return asked, "as asked for"
    value = round(compute(), 2)
    return value, f"{value:g} {source} in that pose"


def _rounded(values: Array) -> list[list[float]]:
    return [[_digits(value) for value in row] for row in values]


def _digits(value: float) -> float:
    return round(float(value), DIGITS) + 0.0  # no -0
