from __future__ import annotations

import warnings

import numpy as np
import pytest
from tiny_map import SOLVED_AT, cold_solve

from gaitflow.core import check
from gaitflow.publishing import Parts
from gaitflow.solvers.interior_point import CENTRED, InteriorPoint, Outcome
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program

BARRIER, FAR_BARRIER = 1e-4, 1e-2
# (gait, speed, cycle duration): where a cold IPOPT finds the same local optimum.
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
def methods(program: Program, spaces: dict[str, GaitSpace]) -> dict[str, InteriorPoint]:
    return {gait: InteriorPoint(program, space) for gait, space in spaces.items()}


def solved_start(parts: Parts, space: GaitSpace, gait: str, task: np.ndarray) -> tuple[Point, float]:
    """The optimum at the task that the gait's start was solved for, and its cost."""
    start = next(each for each in parts.starts if each.gait == gait)
    unit = float(parts.problem.nlp(start.primal, task)[0])
    return space.split(start.primal, start.bounds, start.rows, unit), unit


def violation(parts: Parts, outcome: Outcome, gait: str, task: np.ndarray) -> float:
    trajectory = parts.problem.layout.unpack(outcome.w, task[1])
    return check.worst(parts.problem.scenario.as_data(), trajectory, *task, SOLVED_AT[gait][0])


@pytest.mark.parametrize(("gait", "speed", "cycle"), TASKS)
def test_reaches_ipopts_optimum_from_a_solution_far_away(
    methods: dict, parts: Parts, gait: str, speed: float, cycle: float
) -> None:
    task = np.array([speed, cycle])
    start, unit = solved_start(parts, methods[gait].space, gait, task)
    outcome = methods[gait].follow(task, start, unit, FAR_BARRIER, 30)
    cold = cold_solve(parts.problem, SOLVED_AT[gait][0], speed, cycle)
    assert outcome.converged and cold.feasible
    assert outcome.cost * parts.problem.cost_scale == pytest.approx(cold.cost, rel=1e-6)
    assert violation(parts, outcome, gait, task) <= check.FEASIBLE
    assert outcome.gap <= 1e-5


@pytest.mark.parametrize(("gait", "speed", "cycle"), TASKS)
def test_centre_then_follow_comes_to_the_same_optimum(
    methods: dict, parts: Parts, gait: str, speed: float, cycle: float
) -> None:
    task, method = np.array([speed, cycle]), methods[gait]
    start, unit = solved_start(parts, method.space, gait, task)
    optimum = method.follow(task, start, unit, FAR_BARRIER, 30)
    centred = method.centre(task, start, unit, BARRIER, 60)
    assert centred.converged
    assert centred.gap == pytest.approx(BARRIER * method.space.bounds, rel=CENTRED)
    assert centred.cost > optimum.cost, "bounds push the central path away from the optimum"
    followed = method.follow(task, centred.point, unit, BARRIER, 12)
    assert followed.converged
    assert followed.cost == pytest.approx(optimum.cost, rel=1e-6)
    assert violation(parts, followed, gait, task) <= check.FEASIBLE


@pytest.mark.parametrize(("gait", "speed", "cycle", "most"), [("walking", 0.45, 0.75, 6), ("gallop", 1.45, 0.65, 6)])
def test_a_neighbours_point_needs_a_few_iterations(
    methods: dict, parts: Parts, gait: str, speed: float, cycle: float, most: int
) -> None:
    task, method = np.array([speed, cycle]), methods[gait]
    start, unit = solved_start(parts, method.space, gait, task)
    beside = task + np.array([0.05, 0.01])
    near = method.centre(beside, start, unit, BARRIER, 60)
    outcome = method.follow(task, near.point, unit, BARRIER, 30)
    assert outcome.converged and outcome.iterations <= most
    assert violation(parts, outcome, gait, task) <= check.FEASIBLE


def test_iterations_stay_what_they_were(methods: dict, parts: Parts) -> None:
    """Platforms differ by one or two; more is another method."""
    golden = {TASKS[0]: 5, TASKS[1]: 5, TASKS[2]: 14, TASKS[3]: 10, TASKS[4]: 13, TASKS[5]: 9, TASKS[6]: 9}
    for (gait, *task), iterations in golden.items():
        start, unit = solved_start(parts, methods[gait].space, gait, np.array(task))
        found = methods[gait].follow(np.array(task), start, unit, FAR_BARRIER, 30).iterations
        assert abs(found - iterations) <= 2, (gait, task, found)


@pytest.mark.parametrize("scale", [1.0, 1e3, 1e9, 1e200])
def test_a_lost_run_ends_unconverged_without_a_warning(methods: dict, scale: float) -> None:
    rng, method = np.random.default_rng(0), methods["gallop"]
    space, start = method.space, rng.normal(scale=scale, size=method.space.size)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for run in (method.follow, method.centre):
            outcome = run(np.array([1.3, 0.6]), space.decode(start), 1.0, BARRIER, 30)
            assert not outcome.converged
            assert outcome.iterations <= 30


def test_a_task_that_the_gait_cannot_do_ends_unconverged(methods: dict, parts: Parts) -> None:
    task = np.array([2.05, 0.9])
    start, unit = solved_start(parts, methods["walking"].space, "walking", task)
    outcome = methods["walking"].follow(task, start, unit, FAR_BARRIER, 30)
    assert not outcome.converged
    assert violation(parts, outcome, "walking", task) > check.FEASIBLE


def test_what_is_lost_leaves_no_trace(methods: dict, parts: Parts) -> None:
    task, method = np.array([1.5, 0.7]), methods["gallop"]
    start, unit = solved_start(parts, method.space, "gallop", task)
    before = method.follow(task, start, unit, FAR_BARRIER, 30)
    method.follow(task, method.space.decode(np.full(method.space.size, 1e9)), 1.0, BARRIER, 30)
    after = method.follow(task, start, unit, FAR_BARRIER, 30)
    np.testing.assert_array_equal(before.w, after.w)
    assert (before.cost, before.iterations) == (after.cost, after.iterations)


def test_the_limit_is_kept(methods: dict, parts: Parts) -> None:
    task, method = np.array([0.55, 1.1]), methods["gallop"]
    start, unit = solved_start(parts, method.space, "gallop", task)
    for limit in (0, 1, 5):
        outcome = method.follow(task, start, unit, FAR_BARRIER, limit)
        assert (outcome.converged, outcome.iterations) == (False, limit)
