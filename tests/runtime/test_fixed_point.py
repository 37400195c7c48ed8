"""Two bytes a number, and a power of two for all numbers along an axis."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from gaitflow.runtime.fixed_point import WHOLE, fixed_point, rounded, single

values = arrays(np.float64, array_shapes(min_dims=2, max_dims=3, max_side=5), elements=st.floats(-1e12, 1e12))


@given(values, st.sampled_from([0, 1]))
def test_numbers_are_off_by_a_small_part_of_the_largest(numbers: np.ndarray, axis: int) -> None:
    largest = np.abs(numbers).max(axis=axis, keepdims=True)
    assert (np.abs(rounded(numbers, axis) - numbers) <= np.maximum(largest / WHOLE, 1e-25)).all()


@given(values, st.sampled_from([0, 1]))
def test_what_was_rounded_once_stays(numbers: np.ndarray, axis: int) -> None:
    once = rounded(numbers, axis)
    whole, exponents = fixed_point(once, axis)
    assert whole.dtype == exponents.dtype == np.int16
    np.testing.assert_array_equal(single(whole, exponents), once)


@pytest.mark.parametrize("number", [0.0, 1.0, -1.0, 2.0**-120, 1e30])
def test_single_numbers(number: float) -> None:
    assert rounded(np.full((3, 1), number), 0) == pytest.approx(number, rel=1e-4, abs=1e-30)


def test_an_exponent_that_is_too_large_is_infinite() -> None:
    assert np.isinf(single(np.array([[1]], dtype=np.int16), np.array([[2000]], dtype=np.int16))).all()
