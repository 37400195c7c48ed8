"""How a URDF's legs are built, where they have hip abduction, hip flexion and a knee: what energy is asked of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.mechanism import Array

STRAIGHT = 0.999  # cosine between an axis and where it should point


def limbs_of(
    legs: Sequence[LegChain], centre: Array, feet: Array, pairs: Sequence[tuple[int, int]]
) -> list[dict[str, Any]] | None:
    """Data of limbs (`gaitflow.config.limbs`), exactly left-right symmetric; None where a leg is built otherwise.

    centre [3] m: of mass, in the base link's frame; feet [legs, 3] m: from there, as the robot's file has them.
    """
    found = [_limb(leg, centre, foot) for leg, foot in zip(legs, feet, strict=True)]
    limbs = [limb for limb in found if limb is not None]
    if len(limbs) < len(found):
        return None
    for left, right in pairs:
        limbs[left] = _mean(limbs[left], _mirrored(limbs[right]))
        limbs[right] = _mirrored(limbs[left])
    return [{"leg": leg.name, **_written(limb)} for leg, limb in zip(legs, limbs, strict=True)]


def _limb(leg: LegChain, centre: Array, foot: Array) -> dict[str, Any] | None:
    """Numbers of one leg, None where its joints are not abduction, flexion and knee."""
    if len(leg.joints) != 3:
        return None
    origins, axes = leg.mechanism.axes(leg.joints, leg.pose)
    origins = origins - centre
    flexion, knee = axes[1], axes[2]
    if abs(axes[0, 0]) < STRAIGHT or abs(flexion @ knee) < STRAIGHT or abs(flexion[0]) > 1 - STRAIGHT:
        return None
    across = flexion * np.sign(flexion[1])
    down = -np.cross([1.0, 0.0, 0.0], across)
    thigh, shank = ((a[0], a @ down) for a in (origins[2] - origins[1], foot - origins[2]))
    line = foot - origins[1]
    inertia = leg.mechanism.joint_inertia(leg.joints, leg.pose)
    signs = np.array([[1.0, np.sign(flexion @ knee)], [np.sign(flexion @ knee), 1.0]])
    bent_forward = thigh[0] * (line @ down) - thigh[1] * line[0] > 0
    return {
        "hip": np.array([origins[1, 0], origins[0, 1], origins[0, 2]]),
        "aside": float((foot - origins[0]) @ across),
        "below": float((origins[1] - origins[0]) @ down),
        "thigh": float(np.hypot(*thigh)),
        "shank": float(np.hypot(*shank)),
        "knee": "forward" if bent_forward else "backward",
        "mass": leg.mechanism.carried(leg.joints),
        "abduction_inertia": float(inertia[0, 0]),
        "flexion_inertia": inertia[1:, 1:] * signs,
    }


def _mirrored(limb: dict[str, Any]) -> dict[str, Any]:
    return limb | {"hip": limb["hip"] * [1.0, -1.0, 1.0], "aside": -limb["aside"]}


def _mean(limb: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    return {key: value if key == "knee" else (value + other[key]) / 2 for key, value in limb.items()}


def _written(limb: dict[str, Any]) -> dict[str, Any]:
    """With the digits of a robot's file: micrometres, and a thousandth of what a leg's inertia may be known to."""
    return {key: value if key == "knee" else (np.round(value, 6) + 0.0).tolist() for key, value in limb.items()}
