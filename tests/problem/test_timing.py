from __future__ import annotations

import casadi as ca
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gaitflow.problem.timing import cycle_row, fraction_bounds


@given(st.integers(2, 12), st.floats(0.001, 1.0))
@example(5, 1.0)
@example(10, 1.0)
def test_bounds_never_contradict(phases: int, share: float) -> None:
    """Also where the shortest phases just fill the cycle and rounding decides: 1 - 4 * 0.2 < 0.2."""
    shortest = share * round(1 / phases, 12)
    lower, upper = fraction_bounds(phases, shortest)
    assert lower == shortest
    assert lower <= upper
    assert upper == pytest.approx(1 - (phases - 1) * shortest)


def test_the_cycle_is_filled_when_the_row_is_zero() -> None:
    assert float(cycle_row(ca.DM([0.1, 0.2, 0.3, 0.4]))) == pytest.approx(0.0)
    assert float(cycle_row(ca.DM([0.1, 0.2, 0.3, 0.5]))) == pytest.approx(0.1)
