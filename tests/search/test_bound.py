from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from gaitflow.config.scenario import Objective, Scenario, Terrain, Transcription
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.search.bound import least_cost, ruled_out
from gaitflow.search.screen import NO_ROOM, NO_SUPPORT, NO_SWING, longest_support
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

Solve = Callable[..., Attempt]
OBJECTIVES = {
    "effort": Objective(force=1.0),
    "vibration": Objective(tangential_velocity=1e6, normal_velocity=1e6, tilt=1e6, tilt_rate=1e6),
    "both": Objective(force=1e-2, tangential_velocity=1e3, normal_velocity=1e3, tilt=1e3, tilt_rate=1e3),
}


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("slope", [0.0, 20.0])
@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_no_motion_costs_less_than_its_bound(effort: Scenario, objective: str, slope: float, integrator: str) -> None:
    """Over all patterns of the plane, flight phases among them, and cycles from the nominal start."""
    scenario = effort.model_copy(
        update={
            "objective": OBJECTIVES[objective],
            "terrain": Terrain(slope_deg=slope),
            "transcription": Transcription(knots_per_phase=3, integrator=integrator),
        }
    )
    solver = FixedGaitSolver(transcribe(scenario), 20.0)
    speed, cycle, closest, solved = 0.8, 0.6, math.inf, 0
    for pattern in all_patterns(2, 4, stances_per_leg=1)[::2]:
        start = Start("nominal", starts.nominal(scenario.robot, solver.problem.layout, speed, cycle))
        attempt = solver.solve(pattern, speed, cycle, start)
        if not attempt.feasible:
            continue
        solved += 1
        support = longest_support(scenario, pattern, speed, cycle)
        assert support is not None
        least = least_cost(scenario, pattern, cycle, support)
        assert 0 <= least <= attempt.cost
        if least:
            closest = min(closest, attempt.cost / least)
    assert solved > 8
    assert closest < (1.6 if objective == "effort" else 1e4), "the bound says nothing"


def test_the_bound_by_hand(effort: Scenario) -> None:
    """A pronk: all legs stand 0.9 T at most, and fly a tenth at least."""
    scenario = effort.model_copy(
        update={"objective": Objective(force=2.0, normal_velocity=3.0), "terrain": Terrain(slope_deg=0.0)}
    )
    weight, cycle, n = scenario.robot.mass * 9.81, 0.8, scenario.transcription.knots_per_phase
    h = 0.1 * cycle / n
    velocities = [-9.81 * h * (k - (n - 1) / 2) for k in range(n)]
    expected = 2.0 * (weight * cycle) ** 2 / (2 * 0.9 * cycle) + 3.0 * h * sum(v * v for v in velocities)
    assert least_cost(scenario, Pattern.from_text("0111/0111"), cycle, 2 * 0.9 * cycle) == pytest.approx(
        expected, rel=2e-6
    )


def test_what_is_ruled_out_says_why(effort: Scenario) -> None:
    walk = Pattern.from_text("0111/1101")
    assert ruled_out(effort, walk, 0.3, 0.8) is None
    assert ruled_out(effort, Pattern.from_text("0000/0000"), 0.0, 0.8) == NO_SUPPORT
    assert ruled_out(effort, Pattern.from_text("1111/0110"), 0.3, 0.8) == NO_SWING
    assert ruled_out(effort, walk, 30.0, 0.8) == NO_ROOM
    least = least_cost(effort, walk, 0.8, longest_support(effort, walk, 0.3, 0.8) or math.nan)
    assert ruled_out(effort, walk, 0.3, 0.8, least * 1.000001) is None
    assert ruled_out(effort, walk, 0.3, 0.8, least * 0.999) == (
        f"costs at least {least:.6g}, the incumbent {least * 0.999:.6g}"
    )


def test_the_longest_support_is_the_program_s_optimum(effort: Scenario) -> None:
    """Slow: three phases of least length and the busiest one for the rest. Fast: the feet need time to swing."""
    walk, cycle = Pattern.from_text("0111/1101"), 0.8
    assert longest_support(effort, walk, 0.0, cycle) == pytest.approx(cycle * (0.1 * (1 + 2 + 1) + 0.7 * 2))
    robot = effort.robot.model_copy(update={"max_foot_speed": 2.0})
    slow_feet = effort.model_copy(update={"robot": robot})
    assert longest_support(slow_feet, walk, 0.8, cycle) == pytest.approx(2 * cycle - 2 * 0.8 * cycle / 2.0)
    assert longest_support(slow_feet, walk, 1.9, cycle) is None
