from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tasks_at import at

from gaitflow.core.task import AXES
from gaitflow.problem import GaitProblem
from gaitflow.solvers.program import Program

TASK = at(0.8, 0.7).parameters


@pytest.fixture
def near(problem: GaitProblem, solved: dict) -> tuple[np.ndarray, np.ndarray]:
    """A point beside a motion, where no derivative is nothing, and multipliers."""
    rng = np.random.default_rng(3)
    w = solved["gallop"].attempt.w + 0.05 * rng.normal(size=problem.layout.nw)
    return w, rng.normal(size=problem.ng)


def dense(values: np.ndarray, places: tuple[np.ndarray, np.ndarray], shape: tuple[int, int]) -> np.ndarray:
    matrix = np.zeros(shape)
    matrix[places] = values
    return matrix


def lagrangian(program: Program, w: np.ndarray, multipliers: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Cost, rows, and the gradient of cost + multipliers @ rows."""
    program.evaluate(w, TASK, multipliers)
    jacobian = dense(program.jacobian, program.jacobian_places, (program.row_count, program.variables))
    return float(program.cost[0]), program.rows.copy(), program.gradient + multipliers @ jacobian


def test_cost_and_rows_are_the_problems(program: Program, problem: GaitProblem, near: tuple) -> None:
    cost, rows, _ = lagrangian(program, *near)
    expected_cost, expected_rows = problem.nlp(near[0], TASK)
    assert cost == pytest.approx(float(expected_cost), rel=1e-14)
    np.testing.assert_allclose(rows, np.asarray(expected_rows).ravel(), rtol=1e-12, atol=1e-12)


def test_rows_alone_are_the_same_and_leave_the_rest(program: Program, near: tuple) -> None:
    w, multipliers = near
    program.evaluate(w + 0.1, TASK, multipliers)
    cost, rows = program.cost.copy(), program.rows.copy()
    program.evaluate(w, TASK, multipliers)
    hessian = program.hessian.copy()
    program.evaluate_rows(w + 0.1, TASK)
    np.testing.assert_allclose(program.cost, cost, rtol=1e-14)
    np.testing.assert_allclose(program.rows, rows, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(program.hessian, hessian)


@pytest.mark.parametrize("seed", range(5))
def test_derivatives_are_those_of_finite_differences(program: Program, near: tuple, seed: int) -> None:
    w, multipliers = near
    direction, h = np.random.default_rng(seed).normal(size=len(w)), 1e-6
    program.evaluate(w, TASK, multipliers)
    slope = program.gradient @ direction
    jacobian = dense(program.jacobian, program.jacobian_places, (program.row_count, len(w)))
    triangle = dense(program.hessian, program.hessian_places, (len(w), len(w)))
    assert (program.hessian_places[0] <= program.hessian_places[1]).all()
    curved = (triangle + np.triu(triangle, 1).T) @ direction
    (above, rows_above, gradient_above), (below, rows_below, gradient_below) = (
        lagrangian(program, w + sign * h * direction, multipliers) for sign in (1, -1)
    )
    assert slope == pytest.approx((above - below) / (2 * h), rel=1e-5)
    np.testing.assert_allclose(jacobian @ direction, (rows_above - rows_below) / (2 * h), rtol=1e-5, atol=1e-6)
    scale = np.abs(curved).max()
    np.testing.assert_allclose(curved / scale, (gradient_above - gradient_below) / (2 * h * scale), atol=1e-6)


def test_two_programs_of_one_function_do_not_disturb_each_other(
    problem: GaitProblem, evaluated: Any, near: tuple
) -> None:
    one, other = (Program(problem.separable, evaluated) for _ in range(2))
    w, multipliers = near
    one.evaluate(w, TASK, multipliers)
    names = ("cost", "rows", "gradient", "jacobian", "hessian")
    before = {name: getattr(one, name).copy() for name in names}
    other.evaluate(w + 0.1, TASK + 0.1, 2 * multipliers)
    for name in names:
        np.testing.assert_array_equal(getattr(one, name), before[name])
        assert not np.array_equal(getattr(other, name), before[name]), name
    other.evaluate(w, TASK, multipliers)
    for name in names:
        np.testing.assert_array_equal(getattr(other, name), before[name])


def test_the_arrays_stay_the_same_ones(program: Program, near: tuple) -> None:
    held = program.gradient
    program.evaluate(near[0], TASK, near[1])
    assert program.gradient is held
    assert np.abs(held).max() > 0


def test_it_builds_its_own_derivatives(problem: GaitProblem, program: Program, near: tuple) -> None:
    own = Program(problem.separable)
    for each in (own, program):
        each.evaluate(near[0], TASK, near[1])
    np.testing.assert_array_equal(own.hessian, program.hessian)
    np.testing.assert_array_equal(own.jacobian, program.jacobian)


def test_changes_with_the_task_are_those_of_finite_differences(program: Program, near: tuple) -> None:
    w, multipliers = near
    of_gradient, of_rows = program.by_task(w, TASK, multipliers)
    assert of_gradient.shape == (len(w), len(AXES)) and of_rows.shape == (len(multipliers), len(AXES))
    matter = [axis for number, axis in enumerate(AXES) if of_gradient[:, number].any() or of_rows[:, number].any()]
    assert matter == ["speed", "cycle_duration", "friction"]
    for number, h in enumerate(1e-6 * np.maximum(np.abs(TASK), 1.0)):
        step = h * np.eye(len(TASK))[number]
        ends = []
        for task in (TASK + step, TASK - step):
            program.evaluate(w, task, multipliers)
            jacobian = dense(program.jacobian, program.jacobian_places, (program.row_count, program.variables))
            ends.append((program.gradient + multipliers @ jacobian, program.rows.copy()))
        for found, above, below in zip((of_gradient, of_rows), *ends, strict=True):
            expected = (above - below) / (2 * h)
            np.testing.assert_allclose(found[:, number], expected, atol=1e-5 * max(1.0, np.abs(expected).max()))
