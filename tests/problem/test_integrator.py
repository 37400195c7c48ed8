from __future__ import annotations

from math import factorial

import casadi as ca
import pytest

from gaitflow.problem.integrator import step


@pytest.mark.parametrize(("name", "order"), [("euler", 1), ("rk4", 4)])
def test_a_step_is_the_taylor_polynomial_of_its_order(name: str, order: int) -> None:
    """On x' = a x an explicit method of order p gives the series of exp(a h) up to (a h)^p."""
    a, h = -1.7, 0.4
    stepped = step(name, lambda x: a * x, ca.DM(2.0), ca.DM(h))
    assert float(stepped) == pytest.approx(2.0 * sum((a * h) ** n / factorial(n) for n in range(order + 1)))
