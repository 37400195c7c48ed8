"""Can the legs reach their kinematic boxes? Asked of the URDF's own kinematics, by inverse kinematics.

Eq. (5) lets each foot be anywhere in a box around its default position, and optimal motions use its faces: a box with
a corner that no leg reaches gives base motions that no full-body planner can follow. A distance to the hip would not
see hip offsets and joint limits, and a closed form would know one kind of leg only; inverse kinematics knows them all.
Links that collide are not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats import qmc

from gaitflow.config.file import ConfigError
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.mechanism import Array

REACHED = 1e-3  # m: a foot this close to a point is there
REACHES = (0.05, 3.0)  # m: legs of palm-sized to truck-sized robots
STARTS = 16  # of a search for joint angles; a leg of three joints has at most four solutions
ANYMAL_BOX = np.array([0.16, 0.1, 0.04])  # m, half lengths that full-body planners could follow on ANYmal B,
ANYMAL_REACH = 0.593  # m, whose feet come this far from their hip flexion joints
Signs = tuple[int, ...]
# Corners first: they are the farthest.
PLACES: tuple[Signs, ...] = tuple(sorted(product((-1, 0, 1), repeat=3), key=lambda signs: -sum(map(abs, signs))))
KINDS = ("centre", "face", "edge", "corner")


def distance(leg: LegChain, target: Array) -> float:
    """How near a leg's foot comes to a point [3] m of the base link's frame, within its joint limits [m]."""
    nearest = np.inf
    for start in _starts(leg):
        found = least_squares(
            lambda own: leg.foot_at(own)[0] - target,
            start,
            jac=lambda own: leg.foot_at(own)[1],
            bounds=leg.bounds,
            max_nfev=60,
        )
        nearest = min(nearest, float(np.linalg.norm(found.fun)))
        if nearest < REACHED:
            break
    return nearest


def longest_reach(leg: LegChain) -> float:
    """Longest distance of a leg's foot from its hip flexion joint, within its joint limits [m]."""

    def folded(own: Array) -> tuple[float, Array]:
        foot, foot_jacobian = leg.foot_at(own)
        hip, hip_jacobian = leg.hip_at(own)
        return -float((foot - hip) @ (foot - hip)), -2 * (foot - hip) @ (foot_jacobian - hip_jacobian)

    bounds = list(zip(*leg.bounds, strict=True))
    least = min(minimize(folded, start, jac=True, bounds=bounds, method="L-BFGS-B").fun for start in _starts(leg))
    return float(np.sqrt(-least))


def check_reach(legs: Sequence[LegChain]) -> None:
    """Raises ConfigError when a leg is as long as no robot's, such as that of a URDF in millimetres."""
    for leg in legs:
        reach = longest_reach(leg)
        if not REACHES[0] <= reach <= REACHES[1]:
            raise ConfigError(
                f"leg {leg.name} reaches {reach:.3g} m from {leg.joint_names[leg.hip]}; {REACHES[0]:g} to "
                f"{REACHES[1]:g} m are a robot's: a URDF is in metres, scale this one's lengths to them"
            )


def check_box(legs: Sequence[LegChain], centres: Array, box: Array) -> None:
    """Raises ConfigError that names the leg and the place of its box that are farthest out of reach.

    Judged at 27 points: corners, middles of edges and faces, centre. centres [legs, 3] m: default feet in the base
    link's frame; box [3] m: half lengths.
    """
    missed = [
        (short, leg, centre, signs)
        for leg, centre in zip(legs, centres, strict=True)
        for signs, short in _shortfalls(leg, centre, box)
    ]
    if not missed:
        return
    short, leg, centre, signs = max(missed, key=lambda miss: miss[0])
    target = centre + np.array(signs) * box
    away = float(np.linalg.norm(target - leg.hip_at(leg.stance)[0]))
    raise ConfigError(
        f"box {' x '.join(f'{length:g}' for length in box)} m: leg {leg.name} cannot reach its {_place(signs)}, "
        f"{away:.3f} m from {leg.joint_names[leg.hip]} as the robot stands; its longest reach from there is "
        f"{longest_reach(leg):.3f} m and its foot comes no nearer than {short * 1e3:.0f} mm. Give a smaller --box, or "
        "leave it out for one of ANYmal's proportions that fits"
    )


def default_box(legs: Sequence[LegChain], centres: Array) -> tuple[Array, float]:
    """A box of ANYmal's proportions to the shortest leg's reach, shrunk until all legs reach it: half lengths, factor.

    Half lengths [3] m are rounded down to mm. Raises ConfigError when the legs reach no such box of at least 1 mm.
    """
    full = ANYMAL_BOX * min(longest_reach(leg) for leg in legs) / ANYMAL_REACH
    fits, fails = 0, 101  # per cent of the full size
    while fails - fits > 1:
        percent = 100 if fails > 100 else (fits + fails) // 2
        box = np.floor(full * percent * 10) / 1e3
        pairs = zip(legs, centres, strict=True)
        reached = box.min() <= 0 or not any(True for leg, centre in pairs for _ in _shortfalls(leg, centre, box))
        fits, fails = (percent, fails) if reached else (fits, percent)
    box = np.floor(full * fits * 10) / 1e3
    if box.min() <= 0:
        raise ConfigError("box: the legs reach no box around their feet in this pose: bend the knees more with --pose")
    return box, fits / 100


def _shortfalls(leg: LegChain, centre: Array, box: Array) -> Iterator[tuple[Signs, float]]:
    """Places of a leg's box that it cannot reach, and by how much [m]."""
    for signs in PLACES:
        short = distance(leg, centre + np.array(signs) * box)
        if short >= REACHED:
            yield signs, short


def _starts(leg: LegChain) -> Array:
    """Angles to search from [STARTS, own]: the pose, then a low-discrepancy spread over the limits."""
    low, high = leg.bounds
    spread = qmc.Halton(len(low), scramble=False).random(STARTS)[1:]
    return np.vstack([leg.stance, low + spread * (high - low)])


def _place(signs: Signs) -> str:
    axes = " ".join(f"{'+' if sign > 0 else '-'}{axis}" for sign, axis in zip(signs, "xyz", strict=True) if sign)
    return f"{KINDS[sum(map(abs, signs))]} {axes}".strip()
