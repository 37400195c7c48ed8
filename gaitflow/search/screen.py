"""Necessary conditions that rule a pattern out without solving it; sound: what they exclude is infeasible.

For one task the phase durations d_i, the base's travel s_i along the ground in each phase and each foot's travel
in each of its swings are unknown; what every feasible motion obeys is linear in them:

- the phases fill the cycle, none is shorter than the least fraction (2c), and the travels sum to v T (3a);
- a foot that stands stays in its box while the base moves on (5), so the base's travel over a stance is at most the
  width X that the tilted box can cover along the ground; over a swing the foot's travel differs from the base's by at
  most X;
- a foot moves no faster than its speed limit and advances v T a cycle (3c).

A pattern whose linear program is empty cannot be walked. Gaits that never lift or never set down a foot are ruled out
first. Among what is left, the longest support that the program allows bounds the cost: see `bound`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.optimize import linprog

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, can_move
from gaitflow.core.trajectory import Array

NO_SUPPORT = "no leg ever stands"
NO_SWING = "a leg never leaves the ground"
NO_ROOM = "stance travel and swing speed do not fit into the cycle"


def why_impossible(scenario: Scenario, pattern: Pattern, speed: float, cycle_duration: float) -> str | None:
    """Why no motion with this pattern can do the task v [m/s], T [s]; None when nothing here rules it out."""
    reason = why_no_gait(pattern, speed)
    if reason is None and longest_support(scenario, pattern, speed, cycle_duration) is None:
        reason = NO_ROOM
    return reason


def why_no_gait(pattern: Pattern, speed: float) -> str | None:
    """Why the contacts alone rule a motion at v [m/s] out; None when they do not."""
    if not any(any(pattern.column(phase)) for phase in range(pattern.phases)):
        return NO_SUPPORT
    return NO_SWING if speed > 0 and not can_move(pattern) else None


def longest_support(scenario: Scenario, pattern: Pattern, speed: float, cycle_duration: float) -> float | None:
    """The most that the stances of all legs can last together, a cycle [s]; None when the program is empty."""
    equalities, targets, rows, limits, variable_bounds = _program(scenario, pattern, speed, cycle_duration)
    standing = np.zeros(len(variable_bounds))
    standing[: pattern.phases] = [sum(pattern.column(phase)) for phase in range(pattern.phases)]
    solution = linprog(
        -standing,
        A_ub=rows if len(rows) else None,
        b_ub=limits if len(rows) else None,
        A_eq=equalities,
        b_eq=targets,
        bounds=variable_bounds,
        method="highs",
    )
    if solution.status == 2:
        return None
    # Whatever else the LP solver says, all legs cannot stand longer than always.
    return -float(solution.fun) if solution.status == 0 else pattern.legs * cycle_duration


def reach(robot: Robot, leg: int) -> float:
    """X: width [m] along the ground that a foot can cover in the base's view, over all tilts the robot may take.

    In the plane exact over |pitch| <= max_tilt; in space the diameter of the sphere through the farthest corner.
    """
    default, box = np.array(robot.legs[leg].default_foot), np.array(robot.box)
    corners = np.array(np.meshgrid(*[(-1, 1)] * len(box))).reshape(len(box), -1).T * box + default
    if robot.dimension == 3:
        return 2 * float(np.linalg.norm(corners, axis=1).max())
    span = [_extent(math.hypot(x, z), math.atan2(z, x), robot.max_tilt) for x, z in corners]
    return max(high for _, high in span) - min(low for low, _ in span)


def _extent(radius: float, angle: float, tilt: float) -> tuple[float, float]:
    """Range of radius*cos(angle + t) over |t| <= tilt."""
    ends = [radius * math.cos(angle - tilt), radius * math.cos(angle + tilt)]
    for turn in (-math.pi, 0.0, math.pi):
        if abs(turn - angle) <= tilt:
            ends.append(radius * math.cos(turn))
    return min(ends), max(ends)


def _program(
    scenario: Scenario, pattern: Pattern, speed: float, cycle_duration: float
) -> tuple[Array, Array, Array, Array, list[tuple[float | None, float | None]]]:
    """Equalities, inequalities (<=) and bounds over (d [phases], s [phases], travel of each swing)."""
    robot, phases = scenario.robot, pattern.phases
    swings = [(leg, run) for leg in range(pattern.legs) for run in _runs(pattern.rows[leg], "0")]
    size = 2 * phases + len(swings)
    travel = speed * cycle_duration

    def row(durations: Array | None = None, base: Array | None = None, swing: int | None = None) -> Array:
        values = np.zeros(size)
        if durations is not None:
            values[:phases] = durations
        if base is not None:
            values[phases : 2 * phases] = base
        if swing is not None:
            values[2 * phases + swing] = 1.0
        return values

    everything = np.ones(phases)
    equalities, targets = [row(everything), row(None, everything)], [cycle_duration, travel]
    rows, limits = [], []
    for leg in range(pattern.legs):
        width = reach(robot, leg)
        for run in _runs(pattern.rows[leg], "1"):
            stance = row(None, run)
            rows += [stance, -stance]
            limits += [width, width]
        own = [index for index, (owner, _) in enumerate(swings) if owner == leg]
        equalities.append(sum((row(swing=index) for index in own), np.zeros(size)))
        targets.append(travel)
        for index in own:
            run = swings[index][1]
            foot, base = row(swing=index), row(None, run)
            fastest = row(robot.max_foot_speed * run)
            rows += [foot - fastest, -foot - fastest, foot - base, base - foot]
            limits += [0.0, 0.0, width, width]
    shortest = scenario.transcription.min_phase_fraction * cycle_duration
    bounds: list[tuple[float | None, float | None]] = [(shortest, None)] * phases + [(None, None)] * (size - phases)
    return np.array(equalities), np.array(targets), np.array(rows), np.array(limits), bounds


def _runs(row: str, digit: str) -> Iterator[Array]:
    """Masks [phases] of the cyclic runs of a digit."""
    phases = len(row)
    if set(row) == {digit}:
        yield np.ones(phases)
        return
    for start in range(phases):
        if row[start] == digit and row[start - 1] != digit:
            mask = np.zeros(phases)
            index = start
            while row[index % phases] == digit:
                mask[index % phases] = 1.0
                index += 1
            yield mask
