from __future__ import annotations

import math

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.scenario import Objective, Range, Scenario, Tasks, Transcription
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.search.bound import least_cost, ruled_out
from gaitflow.search.screen import NO_ROOM, NO_SUPPORT, NO_SWING, longest_support, most_support
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

EXACT = {"integrator": "momentum", "forces": "linear", "grading": 0.7}
OBJECTIVES = {
    "effort": Objective(force=1.0),
    "vibration": Objective(tangential_velocity=1e6, normal_velocity=1e6, tilt=1e6, tilt_rate=1e6),
    "both": Objective(force=1e-2, tangential_velocity=1e3, normal_velocity=1e3, tilt=1e3, tilt_rate=1e3),
}


def _with_axes(scenario: Scenario, objective: Objective, **transcription: object) -> Scenario:
    """The scenario with axes for whatever its robot can do."""
    span = Range(start=-0.5, stop=0.5, count=2)
    axes: dict[str, Range | float] = {
        "speed": span,
        "acceleration": span,
        "cycle_duration": Range(start=0.4, stop=1.0, count=2),
        "friction": 0.8,
    }
    axes |= {"lateral_speed": span, "yaw_rate": span} if scenario.robot.dimension == 3 else {"slope": span}
    settings = scenario.transcription.model_dump() | transcription
    changes = {"objective": objective, "tasks": Tasks(axes=axes), "transcription": Transcription(**settings)}
    return scenario.model_copy(update=changes)


def _closest(scenario: Scenario, task: Task, patterns: list[Pattern]) -> tuple[int, float]:
    """How many motions were found, none cheaper than its bound, and the least ratio of a cost to its bound."""
    solver = FixedGaitSolver(transcribe(scenario), 20.0)
    start = Start("nominal", starts.nominal(scenario.robot, solver.problem.layout, task))
    closest, solved = math.inf, 0
    for pattern in patterns:
        attempt = solver.solve(pattern, task, start)
        if not attempt.feasible:
            continue
        solved += 1
        support = longest_support(scenario, pattern, task)
        assert support is not None
        assert support <= most_support(scenario, pattern, task) * (1 + 1e-9)
        least = least_cost(scenario, pattern, task, support)
        assert 0 <= least <= attempt.cost
        if least:
            closest = min(closest, attempt.cost / least)
        assert ruled_out(scenario, pattern, task) is None
        assert ruled_out(scenario, pattern, task, attempt.cost) is None
    return solved, closest


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize(
    "task", [at(0.8, 0.6), at(-0.8, 0.6), at(0.8, 0.6, slope=20.0), at(0.0, 0.5), at(0.5, 0.6, acceleration=1.5)]
)
@pytest.mark.parametrize("rule", [{"integrator": "euler"}, {"integrator": "rk4"}, EXACT, EXACT | {"forces": "held"}])
def test_no_motion_costs_less_than_its_bound(
    effort: Scenario, objective: str, task: Task, rule: dict[str, object]
) -> None:
    """Over patterns of the plane, flight phases among them, and tasks from the nominal start."""
    scenario = _with_axes(effort, OBJECTIVES[objective], knots_per_phase=3, **rule)
    solved, closest = _closest(scenario, task, list(all_patterns(2, 4, stances_per_leg=1)[::3]))
    assert solved > 5
    assert closest < (1.6 if objective == "effort" else 1e4), "the bound says nothing"


@pytest.mark.slow
@pytest.mark.parametrize("rule", [{"integrator": "euler"}, {"integrator": "hermite_simpson"}, EXACT])
@pytest.mark.parametrize(
    "task",
    [
        at(0.5, 0.6, lateral_speed=0.3),
        at(0.0, 0.6, lateral_speed=-0.4),
        at(0.4, 0.6, yaw_rate=0.6),
        at(0.0, 0.6, yaw_rate=1.0, lateral_speed=0.1),
        at(0.5, 0.6, acceleration=1.0),
    ],
)
def test_no_motion_in_space_costs_less_than_its_bound(anymal: Scenario, task: Task, rule: dict[str, object]) -> None:
    objective = Objective(force=1.0, normal_velocity=1e5, tangential_velocity=1e5)
    scenario = _with_axes(anymal, objective, knots_per_phase=3, **rule)
    patterns = ["0111/1101/1101/0111", "0011/1100/1100/0011", "0001/0001/0100/0100", "0111/1011/1110/1101"]
    solved, closest = _closest(scenario, task, [Pattern.from_text(text) for text in patterns])
    assert solved >= 2
    assert closest < 3.0


def test_the_bound_by_hand(effort: Scenario) -> None:
    """A pronk: all legs stand 0.9 T at most, and fly a tenth at least."""
    scenario = effort.model_copy(update={"objective": Objective(force=2.0, normal_velocity=3.0)})
    weight, cycle, n = scenario.robot.mass * 9.81, 0.8, scenario.transcription.knots_per_phase
    h = 0.1 * cycle / n
    velocities = [-9.81 * h * (k - (n - 1) / 2) for k in range(n)]
    expected = 2.0 * (weight * cycle) ** 2 / (2 * 0.9 * cycle) + 3.0 * h * sum(v * v for v in velocities)
    pronk, task = Pattern.from_text("0111/0111"), at(0.3, cycle)
    assert least_cost(scenario, pattern=pronk, task=task, support=2 * 0.9 * cycle) == pytest.approx(expected, rel=2e-6)


def test_the_exact_bound_by_hand(effort: Scenario) -> None:
    """Uphill and faster: forces hold and drive the body; a flight of two phases falls back along the ground, too."""
    objective = Objective(force=2.0, normal_velocity=3.0, tangential_velocity=5.0)
    scenario = _with_axes(effort, objective, **EXACT)
    task, support = at(0.3, 0.8, slope=20.0, acceleration=1.5), 0.9
    along, normal = 9.81 * math.sin(math.radians(20)) + 1.5, 9.81 * math.cos(math.radians(20))
    flight = (2 * 0.1 * 0.8) ** 3 / 12
    expected = 2.0 * (scenario.robot.mass * 0.8) ** 2 * (along**2 + normal**2) / support
    expected += (3.0 * normal**2 + 5.0 * along**2) * flight
    for text in ("0011/0011", "1001/1001"):  # the same flight wherever the cycle is cut
        assert least_cost(scenario, Pattern.from_text(text), task, support) == pytest.approx(expected, rel=2e-6)


def test_longer_phases_only_raise_the_floor_of_a_flight(effort: Scenario) -> None:
    """By Euler's rule on graded knots, over random durations of three phases of flight."""
    scenario = _with_axes(effort, Objective(normal_velocity=1.0), integrator="euler", grading=0.7, knots_per_phase=4)
    cycle, rng = 1.0, np.random.default_rng(0)
    floor = least_cost(scenario, Pattern.from_text("0001/0001"), at(0.5, cycle), 0.5)
    even, cosine = np.linspace(0, 1, 5), (1 - np.cos(np.pi * np.linspace(0, 1, 5))) / 2
    shares = np.diff(0.3 * even + 0.7 * cosine)
    for _ in range(200):
        steps = np.concatenate([duration * shares for duration in 0.1 + rng.exponential(0.05, 3)])
        velocities = -9.81 * (np.cumsum(steps) - steps)
        mean = steps @ velocities / steps.sum()
        assert steps @ (velocities - mean) ** 2 >= floor
    steps = np.tile(0.1 * shares, 3)
    velocities = -9.81 * (np.cumsum(steps) - steps)
    mean = steps @ velocities / steps.sum()
    assert floor == pytest.approx(steps @ (velocities - mean) ** 2, rel=2e-6)


def test_what_is_ruled_out_says_why(effort: Scenario) -> None:
    walk, task = Pattern.from_text("0111/1101"), at(0.3, 0.8)
    assert ruled_out(effort, walk, task) is None
    assert ruled_out(effort, Pattern.from_text("0000/0000"), at(0.0, 0.8)) == NO_SUPPORT
    assert ruled_out(effort, Pattern.from_text("1111/0110"), task) == NO_SWING
    assert ruled_out(effort, walk, at(19.0, 0.8)) == NO_ROOM
    least = least_cost(effort, walk, task, longest_support(effort, walk, task) or math.nan)
    assert ruled_out(effort, walk, task, least * 1.000001) is None
    assert ruled_out(effort, walk, task, least * 0.999) == (
        f"costs at least {least:.6g}, the incumbent {least * 0.999:.6g}"
    )


def test_the_longest_support_is_the_program_s_optimum(effort: Scenario) -> None:
    """Slow: three phases of least length and the busiest one for the rest. Fast: the feet need time to swing."""
    walk, cycle = Pattern.from_text("0111/1101"), 0.8
    assert longest_support(effort, walk, at(0.0, cycle)) == pytest.approx(cycle * (0.1 * (1 + 2 + 1) + 0.7 * 2))
    robot = effort.robot.model_copy(update={"max_foot_speed": 2.0})
    slow_feet = effort.model_copy(update={"robot": robot})
    for speed in (0.8, -0.8):
        expected = 2 * cycle - 2 * 0.8 * cycle / 2.0
        assert longest_support(slow_feet, walk, at(speed, cycle)) == pytest.approx(expected)
        assert most_support(slow_feet, walk, at(speed, cycle)) == pytest.approx(expected)
    assert longest_support(slow_feet, walk, at(1.9, cycle)) is None
