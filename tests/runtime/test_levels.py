"""Bounds in a byte each: the same bounds when read, and none that no level stands for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gaitflow.core.errors import ArtifactError
from gaitflow.runtime.levels import LEVELS, levelled, levels_of, read_bounds
from gaitflow.runtime.tensor_file import TensorFile

VALUES = st.sampled_from([-np.inf, -1.5, 0.0, 1e-9, 0.4, np.inf])


@given(arrays(np.float64, (2, 5), elements=VALUES))
def test_bounds_are_read_as_they_were(bounds: np.ndarray) -> None:
    levels = levels_of([bounds])
    assert levels is not None
    file = TensorFile({"lower": levelled(bounds, levels), LEVELS: levels}, "a file")
    np.testing.assert_array_equal(read_bounds(file, "lower", (2, 5)), bounds)


def test_bounds_of_too_many_values_are_written_out() -> None:
    bounds = np.arange(257.0)
    assert levels_of([bounds]) is None and levels_of([]) is None
    file = TensorFile({"lower": levelled(bounds, None)}, "a file")
    np.testing.assert_array_equal(read_bounds(file, "lower", (257,)), bounds)


@pytest.mark.parametrize(
    ("levels", "fault"),
    [
        (np.array([0.0]), "has level 1; there are 1"),
        (np.array([1.0, 0.0]), "not in ascending order"),
        (np.array([0.0, 0.0]), "not in ascending order"),
        (np.arange(257.0), "more than 256"),
        (np.array([0.0, np.nan]), "holds a value that is not finite"),
    ],
)
def test_levels_that_are_forged_are_refused(levels: np.ndarray, fault: str) -> None:
    file = TensorFile({"lower": np.array([0, 1], dtype=np.uint8), LEVELS: levels}, "a file")
    with pytest.raises(ArtifactError, match=fault):
        read_bounds(file, "lower", (2,))
