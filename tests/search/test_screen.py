from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.problem import transcribe
from gaitflow.search import starts as guess
from gaitflow.search.screen import reach, why_impossible
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

PATTERNS = all_patterns(2, 4)
TRAVEL = "stance travel and swing speed do not fit into the cycle"


@pytest.fixture(scope="module")
def tight(effort: Scenario) -> Scenario:
    """A body that tilts little, whose feet are slow: the screen has much to say, at speeds that solve well."""
    robot = effort.robot.model_copy(update={"max_tilt": 0.1, "max_foot_speed": 3.0, "box": (0.15, 0.1)})
    return effort.model_copy(update={"robot": robot, "transcription": Transcription(knots_per_phase=2)})


@pytest.fixture(scope="module")
def solver(tight: Scenario) -> FixedGaitSolver:
    return FixedGaitSolver(transcribe(tight), 20.0)


def _least_violation(solver: FixedGaitSolver, pattern: Pattern, speed: float, cycle: float) -> float:
    """The least violation of three solves: from the nominal and from two random starts."""
    robot, layout = solver.problem.scenario.robot, solver.problem.layout
    points = [guess.nominal(robot, layout, speed, cycle)]
    points += [guess.random(robot, layout, speed, cycle, np.random.default_rng(seed)) for seed in (0, 1)]
    return min(solver.solve(pattern, speed, cycle, Start("any", w)).violation for w in points)


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("cycle", [0.4, 0.8])
def test_nothing_that_is_screened_out_can_be_solved(
    tight: Scenario, solver: FixedGaitSolver, speed: float, cycle: float
) -> None:
    excluded = [pattern for pattern in PATTERNS if why_impossible(tight, pattern, speed, cycle)]
    assert excluded
    for pattern in excluded:
        assert _least_violation(solver, pattern, speed, cycle) > 1e-4, pattern.text


def test_each_reason_is_met_on_that_grid(tight: Scenario) -> None:
    reasons = [why_impossible(tight, p, v, t) for p in PATTERNS for v in (0.5, 1.0, 1.5) for t in (0.4, 0.8)]
    assert reasons.count("no leg ever stands") == 6
    assert reasons.count("a leg never leaves the ground") == 6 * 11
    assert reasons.count(TRAVEL) > 20
    assert reasons.count(None) > 100


@pytest.mark.parametrize("text", ["0110/1100", "0001/0100", "0111/1101", "0101/1010", "0111/0010", "0000/0011"])
def test_just_beyond_the_fastest_speed_it_allows_nothing_can_be_solved(
    tight: Scenario, solver: FixedGaitSolver, text: str
) -> None:
    pattern, cycle = Pattern.from_text(text), 0.8
    allowed, excluded = 0.0, 4.0
    assert why_impossible(tight, pattern, excluded, cycle) == TRAVEL
    while excluded - allowed > 1e-3:
        middle = (allowed + excluded) / 2
        if why_impossible(tight, pattern, middle, cycle) is None:
            allowed = middle
        else:
            excluded = middle
    assert allowed > 0.1
    assert _least_violation(solver, pattern, excluded * 1.01, cycle) > 1e-4


def test_the_screen_by_hand(effort: Scenario) -> None:
    """A stance at most X long, no shorter than a tenth of T: v <= X / (0.1 T) for the shortest possible stance."""
    width = reach(effort.robot, 0)
    pattern, cycle = Pattern.from_text("0001/0001"), 1.6
    robot = effort.robot.model_copy(update={"max_foot_speed": 1e3})
    fast = effort.model_copy(update={"robot": robot})
    # The base may rush through the flight; only the foot's speed ties its travel to time: nothing is excluded.
    assert why_impossible(fast, pattern, 10 * width / (0.1 * cycle), cycle) is None
    # A foot at 8 m/s for nine tenths of the cycle.
    limit = 0.9 * effort.robot.max_foot_speed
    assert why_impossible(effort, pattern, limit * 0.999, cycle) is None
    assert why_impossible(effort, pattern, limit * 1.001, cycle) == TRAVEL
    # One leg in the air at a time, the other one carries: a cycle is two stances and two swings of at most X each.
    assert why_impossible(fast, Pattern.from_text("0011/1100"), 2 * width / cycle * 0.999, cycle) is None
    assert why_impossible(fast, Pattern.from_text("0011/1100"), 2 * width / cycle * 1.001, cycle) == TRAVEL


def test_standing_still_is_possible(effort: Scenario) -> None:
    for text in ("1111/1111", "1111/0110", "0111/1101"):
        assert why_impossible(effort, Pattern.from_text(text), 0.0, 0.5) is None
    assert why_impossible(effort, Pattern.from_text("1111/0110"), 0.1, 0.5) == "a leg never leaves the ground"
    assert why_impossible(effort, Pattern.from_text("0000/0000"), 0.0, 0.5) == "no leg ever stands"


@pytest.mark.parametrize(("speed", "cycle"), [(0.6, 0.7), (2.6, 0.6)])
def test_no_solved_motion_is_screened_out(coarse: Scenario, speed: float, cycle: float) -> None:
    """Whatever was walked passes, wherever its cycle is cut."""
    solver = FixedGaitSolver(transcribe(coarse), 20.0)
    w = guess.nominal(coarse.robot, solver.problem.layout, speed, cycle)
    walked = 0
    for pattern in all_patterns(2, 4, stances_per_leg=1):
        if solver.solve(pattern, speed, cycle, Start("nominal", w)).feasible:
            walked += 1
            assert not any(why_impossible(coarse, pattern.rotated(cut), speed, cycle) for cut in range(4))
    assert walked > 10


def _sampled_width(robot: Robot, leg: int) -> float:
    """Width along the ground of the box's corners over finely sampled tilts."""
    d = robot.dimension
    default = np.array(robot.legs[leg].default_foot)
    corners = default + np.array(list(itertools.product((-1, 1), repeat=d))) * robot.box
    tilts = np.linspace(-robot.max_tilt, robot.max_tilt, 2001)
    along = np.outer(np.cos(tilts), corners[:, 0]) - np.outer(np.sin(tilts), corners[:, -1])
    return float(along.max() - along.min())


@pytest.mark.parametrize("max_tilt", [0.05, 0.3, 1.0, 1.45])
@pytest.mark.parametrize("foot", [(0.5, -0.5), (-0.5, -0.5), (0.0, -0.3), (0.9, -0.25), (-0.02, -1.0)])
def test_reach_in_the_plane_is_exact(effort: Scenario, max_tilt: float, foot: tuple[float, float]) -> None:
    leg = effort.robot.legs[0].model_copy(update={"default_foot": foot})
    robot = effort.robot.model_copy(update={"legs": (leg,), "max_tilt": max_tilt})
    assert reach(robot, 0) == pytest.approx(_sampled_width(robot, 0), rel=1e-6)


def test_reach_in_space_covers_every_tilt(anymal: Scenario) -> None:
    for leg in range(4):
        farthest = 0.371 if leg < 2 else 0.369
        sphere = 2 * math.hypot(farthest + 0.16, 0.199 + 0.1, 0.458 + 0.04)
        assert reach(anymal.robot, leg) == pytest.approx(sphere)
        assert reach(anymal.robot, leg) >= _sampled_width(anymal.robot, leg)
