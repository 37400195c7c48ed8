from __future__ import annotations

import warnings

import numpy as np
import pytest
from tasks_at import at
from to_solve import nominal
from two_gaits import GAITS, Solved

from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import GaitProblem
from gaitflow.solvers.fixed_gait import FixedGaitSolver
from gaitflow.solvers.interior_point import CENTRED, InteriorPoint, Outcome
from gaitflow.solvers.program import Program

BARRIER, FAR_BARRIER = 1e-4, 1e-2
# (gait, speed, cycle duration): where a cold solve finds the same local optimum.
TASKS = [
    ("walking", 0.2, 0.5),
    ("walking", 0.4, 0.7),
    ("walking", 0.9, 0.6),
    ("gallop", 0.3, 0.6),
    ("gallop", 0.55, 1.1),
    ("gallop", 1.5, 0.7),
    ("gallop", 1.7, 0.6),
]


@pytest.fixture
def methods(program: Program, solved: dict[str, Solved]) -> dict[str, InteriorPoint]:
    return {gait: InteriorPoint(program, each.space) for gait, each in solved.items()}


def violation(problem: GaitProblem, outcome: Outcome, gait: str, task: Task) -> float:
    trajectory = problem.layout.unpack(outcome.w, task.cycle_duration)
    return check.worst(problem.scenario.as_data(), trajectory, task, GAITS[gait][0])


@pytest.mark.parametrize(("gait", "speed", "cycle"), TASKS)
def test_reaches_the_optimum_of_a_cold_solve_from_a_solution_far_away(
    methods: dict, solved: dict, problem: GaitProblem, gait: str, speed: float, cycle: float
) -> None:
    task = at(speed, cycle)
    start, unit = solved[gait].point, solved[gait].unit
    outcome = methods[gait].follow(task.parameters, start, unit, FAR_BARRIER, 30)
    cold = FixedGaitSolver(problem, 20.0).solve(Pattern.from_text(GAITS[gait][0]), task, nominal(problem, task))
    assert outcome.converged and cold.feasible
    assert outcome.cost * problem.cost_scale == pytest.approx(cold.cost, rel=1e-6)
    assert violation(problem, outcome, gait, task) <= check.FEASIBLE
    assert outcome.gap <= 1e-5


@pytest.mark.parametrize(("gait", "speed", "cycle"), TASKS)
def test_centre_then_follow_comes_to_the_same_optimum(
    methods: dict, solved: dict, problem: GaitProblem, gait: str, speed: float, cycle: float
) -> None:
    task, method = at(speed, cycle), methods[gait]
    start, unit = solved[gait].point, solved[gait].unit
    optimum = method.follow(task.parameters, start, unit, FAR_BARRIER, 30)
    centred = method.centre(task.parameters, start, unit, BARRIER, 60)
    assert centred.converged
    assert centred.gap == pytest.approx(BARRIER * method.space.bounds, rel=CENTRED)
    assert centred.cost > optimum.cost, "bounds push the central path away from the optimum"
    followed = method.follow(task.parameters, centred.point, unit, BARRIER, 12)
    assert followed.converged
    assert followed.cost == pytest.approx(optimum.cost, rel=1e-6)
    assert violation(problem, followed, gait, task) <= check.FEASIBLE


@pytest.mark.parametrize(("gait", "speed", "cycle", "most"), [("walking", 0.45, 0.75, 6), ("gallop", 1.45, 0.65, 6)])
def test_a_neighbours_point_needs_a_few_iterations(
    methods: dict, solved: dict, problem: GaitProblem, gait: str, speed: float, cycle: float, most: int
) -> None:
    task, method = at(speed, cycle), methods[gait]
    start, unit = solved[gait].point, solved[gait].unit
    beside = at(speed + 0.05, cycle + 0.01).parameters
    near = method.centre(beside, start, unit, BARRIER, 60)
    outcome = method.follow(task.parameters, near.point, unit, BARRIER, 30)
    assert outcome.converged and outcome.iterations <= most
    assert violation(problem, outcome, gait, task) <= check.FEASIBLE


def test_iterations_stay_what_they_were(methods: dict, solved: dict) -> None:
    """Platforms differ by one or two; more is another method."""
    golden = {TASKS[0]: 5, TASKS[1]: 5, TASKS[2]: 14, TASKS[3]: 10, TASKS[4]: 13, TASKS[5]: 9, TASKS[6]: 9}
    for (gait, *task), iterations in golden.items():
        start, unit = solved[gait].point, solved[gait].unit
        found = methods[gait].follow(at(*task).parameters, start, unit, FAR_BARRIER, 30).iterations
        assert abs(found - iterations) <= 2, (gait, task, found)


@pytest.mark.parametrize("scale", [1.0, 1e3, 1e9, 1e200])
def test_a_lost_run_ends_unconverged_without_a_warning(methods: dict, scale: float) -> None:
    rng, method = np.random.default_rng(0), methods["gallop"]
    space, start = method.space, rng.normal(scale=scale, size=method.space.size)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for run in (method.follow, method.centre):
            outcome = run(at(1.3, 0.6).parameters, space.decode(start), 1.0, BARRIER, 30)
            assert not outcome.converged
            assert outcome.iterations <= 30


def test_a_task_that_the_gait_cannot_do_ends_unconverged(methods: dict, solved: dict, problem: GaitProblem) -> None:
    task = at(2.05, 0.9)
    start, unit = solved["walking"].point, solved["walking"].unit
    outcome = methods["walking"].follow(task.parameters, start, unit, FAR_BARRIER, 30)
    assert not outcome.converged
    assert violation(problem, outcome, "walking", task) > check.FEASIBLE


def test_rows_that_cannot_be_met_are_told_by_their_multipliers(methods: dict, problem: GaitProblem) -> None:
    """From a glide without multipliers, well beyond the longest stride."""
    method, task = methods["walking"], at(6.0, 1.0)
    start = method.space.split(nominal(problem, task).w, np.zeros(problem.layout.nw), np.zeros(problem.ng), 1.0)
    outcome = method.follow(task.parameters, start, 1.0, 0.1, 60, careful=True)
    assert outcome.ending == "infeasible"
    assert 10 <= outcome.iterations <= 40


def test_what_is_lost_leaves_no_trace(methods: dict, solved: dict, problem: GaitProblem) -> None:
    task, method = at(1.5, 0.7), methods["gallop"]
    start, unit = solved["gallop"].point, solved["gallop"].unit
    before = method.follow(task.parameters, start, unit, FAR_BARRIER, 30)
    method.follow(task.parameters, method.space.decode(np.full(method.space.size, 1e9)), 1.0, BARRIER, 30)
    after = method.follow(task.parameters, start, unit, FAR_BARRIER, 30)
    np.testing.assert_array_equal(before.w, after.w)
    assert (before.cost, before.iterations) == (after.cost, after.iterations)


def test_the_limit_is_kept(methods: dict, solved: dict, problem: GaitProblem) -> None:
    task, method = at(0.55, 1.1), methods["gallop"]
    start, unit = solved["gallop"].point, solved["gallop"].unit
    for limit in (0, 1, 5):
        outcome = method.follow(task.parameters, start, unit, FAR_BARRIER, limit)
        assert (outcome.ending, outcome.converged, outcome.iterations) == ("limit", False, limit)
