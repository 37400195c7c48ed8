from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.solvers.point import LARGEST_LOG, GaitSpace, Point

INF = np.inf
FIXED, FREE, ABOVE, BELOW, BETWEEN = (2.0, 2.0), (-INF, INF), (-1.0, INF), (-INF, 3.0), (-1.0, 3.0)
kinds = st.lists(st.sampled_from([FIXED, FREE, ABOVE, BELOW, BETWEEN]), min_size=1, max_size=12)
seeds = st.integers(0, 2**32 - 1)


@st.composite
def spaces(draw: st.DrawFn) -> GaitSpace:
    """Variables and rows of every kind, in any order and number."""
    variables, rows = np.array(draw(kinds)), np.array(draw(kinds))
    return GaitSpace(variables[:, 0], variables[:, 1], rows[:, 0], rows[:, 1])


def point_of(space: GaitSpace, rng: np.random.Generator) -> Point:
    """Any point: both bounds of a variable may push."""
    free, rows = rng.normal(size=len(space.free)), rng.normal(size=space.rows)
    lower, upper = np.exp(rng.uniform(-30, LARGEST_LOG, size=(2, len(space.least))))
    return Point(free, rows, lower * space.has_lower, upper * space.has_upper)


def vectors_of(space: GaitSpace, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What a solver gives: fixed variables at their values, and multipliers of the bounds that there are."""

    def multipliers(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        signed = rng.normal(size=len(lower))
        return np.clip(signed, np.where(np.isfinite(lower), -INF, 0.0), np.where(np.isfinite(upper), INF, 0.0))

    fixed = space.lower == space.upper
    primal = np.where(fixed, space.lower, rng.normal(size=len(space.lower)))
    bounds = np.where(fixed, 0.0, multipliers(space.lower, space.upper))
    return primal, bounds, multipliers(space.lower_rows, space.upper_rows)


def same(one: Point, other: Point) -> None:
    for name in ("free", "rows", "lower", "upper"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=0)


@given(spaces(), seeds)
def test_what_is_encoded_is_decoded(space: GaitSpace, seed: int) -> None:
    point = point_of(space, np.random.default_rng(seed))
    numbers = space.encode(point)
    assert numbers.shape == (space.size,)
    same(space.decode(numbers), point)
    np.testing.assert_allclose(space.encode(space.decode(numbers)), numbers, rtol=1e-12)


@given(spaces(), seeds)
def test_any_numbers_decode_to_multipliers_that_are_positive_and_finite(space: GaitSpace, seed: int) -> None:
    point = space.decode(np.random.default_rng(seed).normal(scale=500.0, size=space.size))
    for pushes, there in ((point.lower, space.has_lower), (point.upper, space.has_upper)):
        assert (pushes[there] >= 0).all() and np.isfinite(pushes).all()
        assert (pushes[~there] == 0).all()


@given(spaces(), seeds, st.floats(1e-3, 1e3))
def test_what_is_split_is_joined(space: GaitSpace, seed: int, unit: float) -> None:
    vectors = vectors_of(space, np.random.default_rng(seed))
    point = space.split(*vectors, unit)
    for found, given_ in zip(space.join(point, unit), vectors, strict=True):
        np.testing.assert_allclose(found, given_, rtol=1e-12)
    same(space.split(*space.join(point, unit), unit), point)


@given(spaces(), seeds)
def test_a_multiplier_pushes_from_the_side_of_its_sign(space: GaitSpace, seed: int) -> None:
    primal, bounds, rows = vectors_of(space, np.random.default_rng(seed))
    point = space.split(primal, bounds, rows, 1.0)
    np.testing.assert_array_equal(point.upper - point.lower, np.concatenate([bounds[space.free], rows[space.unequal]]))
    assert (np.minimum(point.lower, point.upper) == 0).all()


def test_every_row_and_variable_has_its_place() -> None:
    variables, rows = np.array([FIXED, FREE, ABOVE, BELOW]), np.array([FREE, FIXED, BETWEEN, FIXED])
    space = GaitSpace(variables[:, 0], variables[:, 1], rows[:, 0], rows[:, 1])
    assert space.free.tolist() == [1, 2, 3]
    assert space.equal.tolist() == [1, 3]
    assert space.unequal.tolist() == [2]
    assert space.fixed.tolist() == [2, 0, 0, 0]
    assert space.equal_to.tolist() == [2, 2]
    assert (space.rows, space.bounds, space.size) == (3, 4, 3 + 3 + 4)
