from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.core.mesh_error import error_left


def test_on_a_twice_finer_mesh_it_is_what_the_costs_differ_by() -> None:
    assert error_left(102.0, 10, 100.0, 20) == pytest.approx(0.02)
    assert error_left(103.0, 10, 100.0, 40) == pytest.approx(0.01)
    assert error_left(97.0, 10, 100.0, 40) == pytest.approx(0.01)


@given(st.floats(0.1, 50.0), st.floats(1.0, 3.0), st.integers(2, 20), st.integers(2, 5))
def test_no_rule_of_first_order_or_better_is_off_by_more(size: float, order: float, knots: int, finer: int) -> None:
    coarse, fine = (100.0 + size * n**-order for n in (knots, finer * knots))
    assert abs(fine - 100.0) / fine <= error_left(coarse, knots, fine, finer * knots) * (1 + 1e-9)


def test_a_mesh_that_is_not_finer_is_refused() -> None:
    with pytest.raises(ValueError, match="10 knots a phase are no finer"):
        error_left(1.0, 10, 1.0, 10)
