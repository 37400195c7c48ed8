"""What is left of a point gives all of it back, where it is on the central path."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.runtime.condensed import Condenser
from gaitflow.solvers.point import GaitSpace, Point

BARRIER = 1e-4
INF = np.inf
# Variables: without bounds, one below, above, between, fixed; rows: equal, below, above, between, without.
SPACE = GaitSpace(
    np.array([-INF, -1.0, -INF, 0.5, 2.0]),
    np.array([INF, INF, 3.0, 2.5, 2.0]),
    np.array([0.0, -2.0, -INF, -1.0, -INF]),
    np.array([0.0, INF, 5.0, 1.0, INF]),
)
CONDENSER = Condenser(SPACE, BARRIER)
distances = st.floats(1e-9, 10.0)
shares = st.floats(1e-8, 1 - 1e-8)
numbers = st.floats(-5.0, 5.0)
points = st.builds(
    lambda free, below, above, share, row, row_below, row_above, row_share: on_path(
        np.array([free, -1.0 + below, 3.0 - above, 0.5 + 2.0 * share]),
        row,
        np.array([row_below - 2.0, 5.0 - row_above, 2.0 * row_share - 1.0]),
    ),
    numbers, distances, distances, shares, numbers, distances, distances, shares,
)  # fmt: skip


def on_path(variables: np.ndarray, equal: float, rows: np.ndarray) -> np.ndarray:
    """The encoded point of the central path with these variables, multiplier of the equality, and inequality rows."""
    values = np.concatenate([variables, rows])
    lower = np.where(SPACE.has_lower, BARRIER / (values - SPACE.least), 0.0)
    upper = np.where(SPACE.has_upper, BARRIER / (SPACE.most - values), 0.0)
    of_rows = np.concatenate([[equal], (upper - lower)[len(variables) :]])
    return SPACE.encode(Point(variables, of_rows, lower, upper))


@given(points)
def test_a_point_of_the_central_path_comes_back(point: np.ndarray) -> None:
    condensed = CONDENSER.condensed(point)
    assert len(condensed) == CONDENSER.size == sum(CONDENSER.kinds) == 11 < SPACE.size
    back = CONDENSER.expanded(condensed)
    free, rows = len(SPACE.free), SPACE.rows
    np.testing.assert_array_equal(back[:free], point[:free])
    np.testing.assert_allclose(back[free : free + rows], point[free : free + rows], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(back[free + rows :], point[free + rows :], atol=1e-5)


@given(points, points)
def test_tangents_are_condensed_as_points_are(point: np.ndarray, other: np.ndarray) -> None:
    both = CONDENSER.condensed(np.stack([point, other]))
    np.testing.assert_array_equal(both, [CONDENSER.condensed(point), CONDENSER.condensed(other)])
    np.testing.assert_allclose(CONDENSER.condensed(other - point), both[1] - both[0], atol=1e-9)


@pytest.mark.parametrize("number", [1e15, -1e15])
def test_whatever_numbers_a_file_has_the_point_is_finite(number: float) -> None:
    point = CONDENSER.expanded(np.full(CONDENSER.size, number))
    assert np.isfinite(point).all()
    primal, bounds, rows = SPACE.join(SPACE.decode(point), 1.0)
    assert all(np.isfinite(each).all() for each in (primal, bounds, rows))
