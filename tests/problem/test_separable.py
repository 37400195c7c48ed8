"""Elements of a cost: the chain rule against CasADi's own derivatives of the whole expression."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from gaitflow.core.task import AXES
from gaitflow.problem.separable import Element, SeparableProblem

TASK = np.arange(1.0, len(AXES) + 1)
PLACES = np.array([[0, 4, 2], [3, 1, 5]])
WEIGHTS = np.array([2.0, -0.5])


def turned(x: ca.SX, task: ca.SX) -> ca.SX:
    return ca.vertcat(ca.cos(x[0]) * x[1] - x[2] ** 2, ca.sin(x[0]) * x[2] * task[0])


def cost(y: ca.SX, task: ca.SX) -> ca.SX:
    return y[0] ** 2 * y[1] + ca.exp(y[1]) * task[1]


@pytest.fixture(scope="module")
def element() -> Element:
    return Element.chained((turned, cost), PLACES, WEIGHTS)


@pytest.mark.parametrize("seed", range(5))
def test_derivatives_by_the_chain_rule_are_those_of_the_whole(element: Element, seed: int) -> None:
    x, task = ca.SX.sym("x", 3), ca.SX.sym("task", len(AXES))
    whole = cost(turned(x, task), task)
    hessian, gradient = ca.hessian(whole, x)
    expected = ca.Function("expected", [x, task], [whole, gradient, ca.triu(hessian)])
    point = np.random.default_rng(seed).normal(size=3)
    value, slopes, curvatures = expected(point, TASK)
    assert float(element.value(point, TASK)) == pytest.approx(float(value), rel=1e-14)
    found = element.second(point, TASK)
    np.testing.assert_allclose(found[0].full(), slopes.full(), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found[1].full(), curvatures.full(), rtol=1e-12, atol=1e-12)


def test_a_problem_is_its_rest_and_all_copies(element: Element) -> None:
    w, task = ca.SX.sym("w", 6), ca.SX.sym("task", len(AXES))
    rest = ca.Function("rest", [w, task], [ca.sumsqr(w), ca.vertcat(w[0] * w[1], w[5])])
    point = np.random.default_rng(0).normal(size=6)
    found = SeparableProblem(rest, (element, element)).function(point, TASK)
    copies = [float(element.value(point[place], TASK)) for place in PLACES]
    assert float(found[0]) == pytest.approx(point @ point + 2 * (WEIGHTS @ copies), rel=1e-14)
    np.testing.assert_array_equal(found[1].full().ravel(), [point[0] * point[1], point[5]])
    assert SeparableProblem(rest).function is rest
