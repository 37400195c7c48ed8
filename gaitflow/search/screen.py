"""Necessary conditions that rule a pattern out without solving it; sound: what they exclude is infeasible.

Over a cycle the feet have to hold the body up, and to brake or drive it: their forces add up to m (a - g) T, a the mean
acceleration. Friction bounds the part along the ground by the part normal to it, and no foot carries more than its
limit.

For a task that does not turn, the phase durations d_i, the base's travel s_i along the way in each phase and each
foot's travel in each of its swings are unknown; what every feasible motion obeys is linear in them:

- the phases fill the cycle, none is shorter than the least fraction (2c), and the travels sum to |D| (3a), the
  displacement D = (v, v_y) T of a cycle;
- a foot that stands stays in its box while the base moves on (5), so the base's travel over a stance is at most the
  width X that the tilted box can cover along the way; over a swing the foot's travel differs from the base's by at
  most X;
- a foot moves no faster along each axis than its speed limit and advances |D| a cycle (3c).

A pattern whose linear program is empty cannot be walked. A body that turns may do so about any point, a foot of its own
included, so that no travel is known: only its forces are judged. Among what is left, the longest support that the
program allows bounds the cost: see `bound`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import linprog

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array

NO_SUPPORT = "no leg ever stands"
NO_SWING = "a leg never leaves the ground"
NO_ROOM = "stance travel and swing speed do not fit into the cycle"
NO_STRENGTH = "stances are too short to carry the body"
NO_GRIP = "friction cannot hold the body on this ground"
IMPOSSIBLE = (NO_SUPPORT, NO_SWING, NO_ROOM, NO_STRENGTH, NO_GRIP)  # all that `why_impossible` may say
ROUNDING = 1e-6  # relative, by which a limit has to be exceeded: what our check lets pass


@dataclass(frozen=True)
class Demand:
    """What a task asks of the robot over a cycle; SI units.

    travel: |D|, and `spread` how much faster than along one axis a foot may move along it, |u_x| + |u_y| for its
    direction u. turning: the body's path is not known. normal, along: mean acceleration that the feet's forces give
    the body, normal to the ground and along it; the latter is 0, as nothing is known of it, where the body turns.
    """

    mass: float
    cycle_duration: float
    travel: float
    spread: float
    turning: bool
    normal: float
    along: float


def demand_of(robot: Robot, task: Task) -> Demand:
    """The demand of a task, along x where it stands still."""
    slope, turning = math.radians(task["slope"]), task["yaw_rate"] != 0
    forward, left = task["speed"] * task.cycle_duration, task["lateral_speed"] * task.cycle_duration
    travel = math.hypot(forward, left)
    spread = (abs(forward) + abs(left)) / travel if travel else 1.0
    along = 0.0 if turning else abs(GRAVITY * math.sin(slope) + task["acceleration"])
    mass = robot.mass + task["payload"]
    return Demand(mass, task.cycle_duration, travel, spread, turning, GRAVITY * math.cos(slope), along)


def why_impossible(scenario: Scenario, pattern: Pattern, task: Task) -> str | None:
    """Why no motion with this pattern can do the task; None when nothing here rules it out."""
    demand = demand_of(scenario.robot, task)
    if not any("1" in row for row in pattern.rows):
        return NO_SUPPORT
    if demand.along > task["friction"] * demand.normal * (1 + ROUNDING):
        return NO_GRIP
    if demand.travel and not demand.turning and any("0" not in row for row in pattern.rows):
        return NO_SWING
    needed = demand.mass * demand.normal * demand.cycle_duration / scenario.robot.max_force
    if _most_support(scenario, pattern, demand) >= needed and _glides(scenario, pattern, demand):
        return None  # as for most patterns: not worth a linear program
    support = longest_support(scenario, pattern, task)
    if support is None:
        return NO_ROOM
    return NO_STRENGTH if support < needed * (1 - ROUNDING) else None


def longest_support(scenario: Scenario, pattern: Pattern, task: Task) -> float | None:
    """The most that the stances of all legs can last together, a cycle [s]; None when the program is empty."""
    demand = demand_of(scenario.robot, task)
    if demand.turning:
        return _most_support(scenario, pattern, demand)
    equalities, targets, rows, limits, variable_bounds = _program(scenario, pattern, demand)
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
    # Whatever else the LP solver says, legs cannot stand longer than when every other phase is as short as allowed.
    return -float(solution.fun) if solution.status == 0 else _most_support(scenario, pattern, demand)


def most_support(scenario: Scenario, pattern: Pattern, task: Task) -> float:
    """An upper bound of `longest_support` without a linear program [s]."""
    return _most_support(scenario, pattern, demand_of(scenario.robot, task))


def _most_support(scenario: Scenario, pattern: Pattern, demand: Demand) -> float:
    """Stances [s] when every phase is as short as allowed but the one with most legs on the ground.

    Nor can a leg stand longer than its swing, at full speed, leaves of the cycle.
    """
    shortest, cycle = scenario.transcription.min_phase_fraction, demand.cycle_duration
    standing = [sum(pattern.column(phase)) for phase in range(pattern.phases)]
    longest = cycle * (shortest * sum(standing) + (1 - shortest * pattern.phases) * max(standing))
    if demand.turning:
        return longest
    swing = demand.travel / (scenario.robot.max_foot_speed * demand.spread)
    return min(longest, pattern.legs * max(0.0, cycle - swing))


def _glides(scenario: Scenario, pattern: Pattern, demand: Demand) -> bool:
    """Whether a point of the linear program is at hand: the base at constant speed, for one of some durations."""
    if demand.turning:
        return True
    shortest, phases = scenario.transcription.min_phase_fraction, pattern.phases
    spare = 1 - shortest * phases
    robot, travel = scenario.robot, demand.travel
    fastest = robot.max_foot_speed * demand.spread * demand.cycle_duration
    for shares in (np.full(phases, 1 / phases), *(shortest + spare * unit for unit in np.eye(phases))):
        for leg, row in enumerate(pattern.rows):
            width = reach(robot, leg)
            stances = [float(shares @ run) for run in _runs(row, "1")]
            swings = np.array([float(shares @ run) for run in _runs(row, "0")])
            moved = travel * swings / swings.sum() if len(swings) else np.zeros(0)
            if (
                max(stances, default=0.0) * travel > width
                or (moved > fastest * swings).any()
                or (np.abs(moved - travel * swings) > width).any()
                or (len(swings) == 0 and travel > 0)
            ):
                break
        else:
            return True
    return False


@lru_cache(maxsize=64)
def _reach(dimension: int, default: tuple[float, ...], box: tuple[float, ...], max_tilt: float) -> float:
    corners = np.array(np.meshgrid(*[(-1, 1)] * len(box))).reshape(len(box), -1).T * np.array(box) + np.array(default)
    if dimension == 3:
        return 2 * float(np.linalg.norm(corners, axis=1).max())
    span = [_extent(math.hypot(x, z), math.atan2(z, x), max_tilt) for x, z in corners]
    return max(high for _, high in span) - min(low for low, _ in span)


def reach(robot: Robot, leg: int) -> float:
    """X: width [m] along the ground that a foot can cover in the base's view, over all tilts the robot may take.

    In the plane exact over |pitch| <= max_tilt; in space the diameter of the sphere through the farthest corner.
    """
    return _reach(robot.dimension, robot.legs[leg].default_foot, robot.box, robot.max_tilt)


def _extent(radius: float, angle: float, tilt: float) -> tuple[float, float]:
    """Range of radius*cos(angle + t) over |t| <= tilt."""
    ends = [radius * math.cos(angle - tilt), radius * math.cos(angle + tilt)]
    for turn in (-math.pi, 0.0, math.pi):
        if abs(turn - angle) <= tilt:
            ends.append(radius * math.cos(turn))
    return min(ends), max(ends)


def _program(
    scenario: Scenario, pattern: Pattern, demand: Demand
) -> tuple[Array, Array, Array, Array, list[tuple[float | None, float | None]]]:
    """Equalities, inequalities (<=) and bounds over (d [phases], s [phases], travel of each swing)."""
    robot, phases = scenario.robot, pattern.phases
    swings = [(leg, run) for leg in range(pattern.legs) for run in _runs(pattern.rows[leg], "0")]
    size = 2 * phases + len(swings)

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
    equalities, targets = [row(everything), row(None, everything)], [demand.cycle_duration, demand.travel]
    rows, limits = [], []
    for leg in range(pattern.legs):
        width = reach(robot, leg)
        for run in _runs(pattern.rows[leg], "1"):
            stance = row(None, run)
            rows += [stance, -stance]
            limits += [width, width]
        own = [index for index, (owner, _) in enumerate(swings) if owner == leg]
        equalities.append(sum((row(swing=index) for index in own), np.zeros(size)))
        targets.append(demand.travel)
        for index in own:
            run = swings[index][1]
            foot, base = row(swing=index), row(None, run)
            fastest = row(robot.max_foot_speed * demand.spread * run)
            rows += [foot - fastest, -foot - fastest, foot - base, base - foot]
            limits += [0.0, 0.0, width, width]
    shortest = scenario.transcription.min_phase_fraction * demand.cycle_duration
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
