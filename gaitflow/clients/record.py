"""What is measured of a walk, and what it comes to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.layout import GRAVITY
from gaitflow.core.trajectory import Array

SLOWER, LEAST_SLOWER = 0.2, 0.05  # of the commanded speed, and m/s: farther off is not walked
LEAST_TURN = 0.1  # rad/s, beside the same share of the commanded one
STAYS = 0.01  # m/s: a command that is slower goes nowhere
IMPACT = 0.03  # s after a touchdown


@dataclass(frozen=True, eq=False)
class Moment:
    """A robot after a physics step: base, feet, motors, and where its plan wants the base. SI units, plan's world.

    joint_velocity and torque [joints]; forces [legs, 3] of the ground on the feet, sliding [legs] m/s.
    """

    time: float
    position: Array
    velocity: Array
    tilt: float
    joint_velocity: Array
    torque: Array
    saturated: bool
    heading: float
    forces: Array
    sliding: Array
    planned_position: Array
    planned_velocity: Array
    planned_heading: float


@dataclass(frozen=True)
class WalkRecord:
    """How a robot walked, over the measured part of `duration` s. SI units.

    walked: it did not fall, its mean velocity was within 20 % of the commanded speed, or 0.05 m/s, and it turned as
    fast as commanded within 20 %, or 0.1 rad/s. fell: when it fell [s], None when it did not; then the numbers are
    those of the part before. velocity (ahead, to the left) is the mean in the plan's heading, commanded is the plan's;
    turning and commanded_turning are the mean turning rates to the left [rad/s]. distance m. cost_of_transport:
    positive mechanical work of all joints over m g distance, with the plan's mass; None where the command is to stay.
    heat: the integral of tau^2, summed over joints [N^2 m^2 s]. mean_square_force: of the feet's forces, summed over
    legs, mean over time [N^2]. tilt: rms, from the ground's normal [rad]. slip: m a stance. saturated: share of time
    with a motor at its limit. position_error, velocity_error: rms distance of the base from the plan's [m, m/s];
    heading_error: of its heading [rad]. impact: largest force on a foot within 30 ms after it touched down [N];
    stances: how many.
    """

    walked: bool
    fell: float | None
    duration: float
    distance: float
    velocity: tuple[float, float]
    commanded: tuple[float, float]
    turning: float
    commanded_turning: float
    cost_of_transport: float | None
    heat: float
    mean_square_force: float
    tilt: float
    slip: float
    saturated: float
    position_error: float
    velocity_error: float
    heading_error: float
    impact: float
    stances: int

    def as_data(self) -> dict[str, object]:
        """The fields as plain data."""
        return {each.name: getattr(self, each.name) for each in fields(self)}


def record_of(moments: Sequence[Moment], step: float, mass: float, fell: float | None) -> WalkRecord:
    """The record of moments `step` s apart of a robot of `mass` kg, which fell at a time [s] or did not."""

    def column(name: str) -> Array:
        return np.array([getattr(moment, name) for moment in moments])

    duration = step * len(moments)
    heading, planned_heading = np.unwrap(column("heading")), np.unwrap(column("planned_heading"))
    velocity = _ahead(column("velocity"), planned_heading)
    commanded = _ahead(column("planned_velocity"), planned_heading)
    speed = float(np.linalg.norm(commanded))
    turning, wanted = (float(each[-1] - each[0]) / duration for each in (heading, planned_heading))
    kept = float(np.linalg.norm(velocity - commanded)) <= max(SLOWER * speed, LEAST_SLOWER)
    turned = abs(turning - wanted) <= max(SLOWER * abs(wanted), LEAST_TURN)
    torque, forces = column("torque"), column("forces")
    work = step * float(np.maximum(torque * column("joint_velocity"), 0.0).sum())
    loads = np.linalg.norm(forces, axis=2)
    lasting = round(IMPACT / step)
    touchdowns = _touchdowns(loads > 0, lasting)
    distance = float(np.linalg.norm(velocity)) * duration
    return WalkRecord(
        walked=fell is None and kept and turned,
        fell=fell,
        duration=duration,
        distance=distance,
        velocity=(float(velocity[0]), float(velocity[1])),
        commanded=(float(commanded[0]), float(commanded[1])),
        turning=turning,
        commanded_turning=wanted,
        cost_of_transport=work / (mass * GRAVITY * max(distance, 1e-9)) if speed > STAYS else None,
        heat=step * float((torque**2).sum()),
        mean_square_force=float((loads**2).sum(axis=1).mean()),
        tilt=_rms(column("tilt")),
        slip=step * float((column("sliding") * (loads > 0)).sum()) / max(len(touchdowns), 1),
        saturated=float(column("saturated").mean()),
        position_error=_rms(np.linalg.norm(column("position") - column("planned_position"), axis=1)),
        velocity_error=_rms(np.linalg.norm(column("velocity") - column("planned_velocity"), axis=1)),
        heading_error=_rms((heading - planned_heading + np.pi) % (2 * np.pi) - np.pi),
        impact=max((float(loads[i : i + lasting, leg].max()) for i, leg in touchdowns), default=0.0),
        stances=len(touchdowns),
    )


def _ahead(velocity: Array, heading: Array) -> Array:
    """The mean of velocities [n, 3] along headings [n] rad and to their left [2] m/s."""
    (vx, vy, _), cos, sin = velocity.T, np.cos(heading), np.sin(heading)
    return np.array([(cos * vx + sin * vy).mean(), (cos * vy - sin * vx).mean()])


def _touchdowns(touching: NDArray[np.bool_], least: int) -> list[tuple[int, int]]:
    """Moment and leg of each touchdown: a foot touches that has been in the air for `least` moments; it may bounce."""
    found = []
    for leg, column in enumerate(touching.T):
        moments = np.flatnonzero(column)
        found += [(int(i), leg) for i in moments[1:][np.diff(moments) > least]]
    return found


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))
