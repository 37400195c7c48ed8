from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from tasks_at import at

from benchmarks.paper import big_m
from benchmarks.paper.big_m import BigMSolver
from gaitflow.config.scenario import Scenario
from gaitflow.core.check import FEASIBLE, violations
from gaitflow.core.gaits import Pattern
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

GALLOP, TASK = Pattern.from_text("0110/1100"), at(1.3, 0.6)


@pytest.fixture(scope="module")
def problem(scenario: Scenario) -> GaitProblem:
    return transcribe(scenario)


@pytest.fixture(scope="module")
def start(problem: GaitProblem) -> Start:
    return Start("nominal", starts.nominal(problem.scenario.robot, problem.layout, TASK))


@pytest.fixture(scope="module")
def optimum(problem: GaitProblem, start: Start) -> Attempt:
    """Of the bounds form."""
    return FixedGaitSolver(problem, 20.0).solve(GALLOP, TASK, start)


@pytest.fixture(scope="module")
def attempt(problem: GaitProblem, optimum: Attempt) -> Attempt:
    """Of the big-M form, started there."""
    return BigMSolver(problem, 20.0).solve(GALLOP, TASK, Start("optimum", optimum.w))


def test_big_m_and_bounds_are_the_same_problem(problem: GaitProblem, optimum: Attempt, attempt: Attempt) -> None:
    bounds = problem.minlp_bounds(GALLOP)
    point = np.concatenate([optimum.w, bounds.lower[problem.layout.nw :]])
    cost, rows = (np.asarray(part).ravel() for part in problem.minlp(point, TASK.parameters))
    assert np.maximum(bounds.lower_rows - rows, rows - bounds.upper_rows).max() < 5e-7
    assert cost[0] * problem.cost_scale == pytest.approx(optimum.cost)
    assert attempt.feasible, attempt.solver_status
    assert attempt.cost == pytest.approx(optimum.cost, rel=1e-4)
    assert attempt.w.shape == (problem.layout.nw,)
    assert attempt.start == "optimum"


def test_swing_forces_are_rows_and_still_within_the_one_tolerance(problem: GaitProblem, attempt: Attempt) -> None:
    found = violations(problem.scenario.as_data(), attempt.trajectory, TASK, GALLOP.text)
    assert max(found.values()) == attempt.violation <= FEASIBLE
    swing = np.repeat(np.array([[row[phase] == "0" for row in GALLOP.rows] for phase in range(4)]), 3, axis=0)
    assert np.abs(attempt.trajectory.forces[swing]).max() <= 1e-6 * problem.layout.weight
    other = violations(problem.scenario.as_data(), attempt.trajectory, TASK, "1001/0011")
    assert other["force in swing"] > 0.1, "the check does look at the pattern"


def test_a_limit_is_a_failure_that_gave_up(problem: GaitProblem, start: Start, monkeypatch) -> None:
    monkeypatch.setattr(big_m, "MAX_ITERATIONS", 2)
    attempt = BigMSolver(problem, 20.0).solve(GALLOP, TASK, start)
    assert attempt.solver_status == "Maximum_Iterations_Exceeded"
    assert attempt.gave_up and not attempt.feasible


def test_a_task_that_cannot_be_is_infeasible(problem: GaitProblem, start: Start) -> None:
    attempt = BigMSolver(problem, 20.0).solve(Pattern.from_text("1111/1111"), TASK, start)
    assert not attempt.feasible
    assert attempt.violation > FEASIBLE


def test_another_shape_is_refused() -> None:
    layout = SimpleNamespace(legs=2, phases=4)
    fake = SimpleNamespace(layout=layout)
    with pytest.raises(ValueError, match="pattern 011/110 has 2 legs and 3 phases; the scenario has 2 and 4"):
        BigMSolver.solve(SimpleNamespace(problem=fake), Pattern.from_text("011/110"), TASK, None)  # type: ignore[arg-type]
