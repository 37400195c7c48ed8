from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Scenario, Transcription
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.problem import transcribe
from gaitflow.search import starts as guess
from gaitflow.search.screen import NO_GRIP, NO_STRENGTH, longest_support, reach, why_impossible
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
    task = at(speed, cycle)
    points = [guess.nominal(robot, layout, task)]
    points += [guess.random(robot, layout, task, np.random.default_rng(seed)) for seed in (0, 1)]
    return min(solver.solve(pattern, task, Start("any", w)).violation for w in points)


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("cycle", [0.4, 0.8])
def test_nothing_that_is_screened_out_can_be_solved(
    tight: Scenario, solver: FixedGaitSolver, speed: float, cycle: float
) -> None:
    excluded = [pattern for pattern in PATTERNS if why_impossible(tight, pattern, at(speed, cycle))]
    assert excluded
    for pattern in excluded:
        assert _least_violation(solver, pattern, speed, cycle) > 1e-4, pattern.text


def test_each_reason_is_met_on_that_grid(tight: Scenario) -> None:
    reasons = [why_impossible(tight, p, at(v, t)) for p in PATTERNS for v in (0.5, 1.0, 1.5) for t in (0.4, 0.8)]
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
    assert why_impossible(tight, pattern, at(excluded, cycle)) == TRAVEL
    while excluded - allowed > 1e-3:
        middle = (allowed + excluded) / 2
        if why_impossible(tight, pattern, at(middle, cycle)) is None:
            allowed = middle
        else:
            excluded = middle
    assert allowed > 0.1
    assert _least_violation(solver, pattern, excluded * 1.01, cycle) > 1e-4


def test_the_screen_by_hand(effort: Scenario) -> None:
    """A stance at most X long, no shorter than a tenth of T: v <= X / (0.1 T) for the shortest possible stance."""
    width = reach(effort.robot, 0)
    pattern, cycle = Pattern.from_text("0001/0001"), 1.6
    strong = effort.robot.model_copy(update={"max_force": 1e5})
    effort = effort.model_copy(update={"robot": strong})
    fast = effort.model_copy(update={"robot": strong.model_copy(update={"max_foot_speed": 1e3})})
    # The base may rush through the flight; only the foot's speed ties its travel to time: nothing is excluded.
    assert why_impossible(fast, pattern, at(2 * width / (0.1 * cycle), cycle)) is None
    # A foot at 8 m/s for nine tenths of the cycle.
    limit = 0.9 * effort.robot.max_foot_speed
    assert why_impossible(effort, pattern, at(limit * 0.999, cycle)) is None
    assert why_impossible(effort, pattern, at(limit * 1.001, cycle)) == TRAVEL
    # One leg in the air at a time, the other one carries: a cycle is two stances and two swings of at most X each.
    assert why_impossible(fast, Pattern.from_text("0011/1100"), at(2 * width / cycle * 0.999, cycle)) is None
    assert why_impossible(fast, Pattern.from_text("0011/1100"), at(2 * width / cycle * 1.001, cycle)) == TRAVEL


@pytest.mark.parametrize(("speed", "lateral_speed"), [(0.3, 0.4), (-0.5, 0.0), (0.0, -0.5)])
def test_all_directions_of_travel_are_alike(anymal: Scenario, speed: float, lateral_speed: float) -> None:
    """A foot that moves at most 2 m/s along each axis is faster across them; reach in space is a sphere's."""
    robot = anymal.robot.model_copy(update={"max_foot_speed": 2.0})
    scenario, trot, cycle = anymal.model_copy(update={"robot": robot}), Pattern.from_text("0111/1101/1101/0111"), 0.5
    support = longest_support(scenario, trot, at(speed, cycle, lateral_speed=lateral_speed))
    swing = 0.5 * cycle / (2.0 * (abs(speed) + abs(lateral_speed)) / 0.5)
    assert support == pytest.approx(min(4 * (cycle - swing), cycle * (0.2 * (2 + 4 + 2) + 0.4 * 4)))


def test_what_turns_is_judged_by_its_forces_alone(anymal: Scenario) -> None:
    """A body may pivot about a foot that never leaves the ground; but feet have to carry it."""
    for text in ("1111/0111/1101/1011", "0111/1101/1101/0111"):
        assert why_impossible(anymal, Pattern.from_text(text), at(1.0, 0.6, yaw_rate=0.5)) is None
    assert why_impossible(anymal, Pattern.from_text("1111/0111/1101/1011"), at(1.0, 0.6)) is not None
    weak = anymal.robot.model_copy(update={"max_force": 100.0})
    tired, trot = anymal.model_copy(update={"robot": weak}), Pattern.from_text("0011/1100/1100/0011")
    assert why_impossible(tired, trot, at(0.2, 0.6, yaw_rate=0.5)) == NO_STRENGTH
    assert why_impossible(tired, trot, at(0.2, 0.6)) == NO_STRENGTH


def test_the_weight_needs_long_enough_stances(effort: Scenario) -> None:
    """At most m g T = F_max S: a pronk on both feet for 0.7 T at most."""
    pronk, cycle = Pattern.from_text("0001/0001"), 0.8
    least = effort.robot.mass * 9.81 / (2 * 0.7)
    for share, expected in ((1.001, None), (0.999, NO_STRENGTH)):
        robot = effort.robot.model_copy(update={"max_force": least * share})
        scenario = effort.model_copy(update={"robot": robot})
        assert why_impossible(scenario, pronk, at(0.3, cycle)) == expected
    # On a slope the ground carries less of it.
    robot = effort.robot.model_copy(update={"max_force": least * 0.999})
    assert why_impossible(effort.model_copy(update={"robot": robot}), pronk, at(0.3, cycle, slope=5.0)) is None


def test_friction_holds_up_to_its_angle(effort: Scenario) -> None:
    walk, steepest = Pattern.from_text("0111/1101"), math.degrees(math.atan(0.4))
    for sign in (1, -1):
        assert why_impossible(effort, walk, at(0.3, 0.6, slope=sign * steepest * 0.999, friction=0.4)) is None
        assert why_impossible(effort, walk, at(0.3, 0.6, slope=sign * steepest * 1.001, friction=0.4)) == NO_GRIP
    assert why_impossible(effort, walk, at(0.3, 0.6, acceleration=4.0, friction=0.4)) == NO_GRIP
    assert why_impossible(effort, walk, at(0.3, 0.6, acceleration=-3.9, friction=0.4)) is None


def test_standing_still_is_possible(effort: Scenario) -> None:
    for text in ("1111/1111", "1111/0110", "0111/1101"):
        assert why_impossible(effort, Pattern.from_text(text), at(0.0, 0.5)) is None
    assert why_impossible(effort, Pattern.from_text("1111/0110"), at(0.1, 0.5)) == "a leg never leaves the ground"
    assert why_impossible(effort, Pattern.from_text("0000/0000"), at(0.0, 0.5)) == "no leg ever stands"


@pytest.mark.parametrize(("speed", "cycle"), [(0.6, 0.7), (2.6, 0.6)])
def test_no_solved_motion_is_screened_out(coarse: Scenario, speed: float, cycle: float) -> None:
    """Whatever was walked passes, wherever its cycle is cut."""
    solver = FixedGaitSolver(transcribe(coarse), 20.0)
    w = guess.nominal(coarse.robot, solver.problem.layout, at(speed, cycle))
    walked = 0
    for pattern in all_patterns(2, 4, stances_per_leg=1):
        if solver.solve(pattern, at(speed, cycle), Start("nominal", w)).feasible:
            walked += 1
            assert not any(why_impossible(coarse, pattern.rotated(cut), at(speed, cycle)) for cut in range(4))
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
