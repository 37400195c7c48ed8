"""Where a plan may start, over few axes and over many."""

from __future__ import annotations

import numpy as np
import pytest

from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.starts import Start, starts_of
from tests.helpers.sheets import LAYOUT, sheet, space

NOMINAL = np.linspace(-0.5, 0.5, LAYOUT.nw)
COST = 3.0


def atlas(axes: int) -> Atlas:
    """Two nodes, one at 0 and one a step away."""
    places = np.zeros((2, axes))
    places[1, 0] = 1.0
    names = ("speed", "lateral_speed", "yaw_rate", "cycle_duration", "slope")[:axes]
    return Atlas(names, np.ones(axes), 1e-4, (sheet(places, np.full(2, COST), np.zeros((2, axes))),))


def starts(axes: int, place: Array) -> list[Start]:
    return list(starts_of(atlas(axes), 0, place, lambda: NOMINAL))


def is_nominal(start: Start) -> bool:
    multipliers = (start.point.rows, start.point.lower, start.point.upper)
    return np.array_equal(start.point.free, NOMINAL[space().free]) and not any(each.any() for each in multipliers)


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_over_few_axes_the_prediction_is_first_and_the_nominal_start_last(axes: int) -> None:
    first, second, third, last = starts(axes, np.full(axes, 0.2))
    assert first.careful and first.point.lower.any() and first.unit == pytest.approx(COST)
    np.testing.assert_array_equal(second.point.free, first.point.free)
    assert not second.point.lower.any() and second.barrier > third.barrier > first.barrier
    assert third.point.lower.any() and not third.careful
    assert is_nominal(last) and last.careful and last.unit == pytest.approx(COST)


@pytest.mark.parametrize("axes", [4, 5])
def test_over_many_axes_the_nominal_start_is_first(axes: int) -> None:
    first, *others = starts(axes, np.full(axes, 0.2))
    assert is_nominal(first) and first.careful and first.unit == pytest.approx(COST)
    assert len(others) == 3 and not any(is_nominal(each) for each in others)


@pytest.mark.parametrize(("axes", "nominal"), [(2, [False, True]), (4, [True, False])])
def test_far_from_all_nodes_a_node_and_the_nominal_start_are_left(axes: int, nominal: list[bool]) -> None:
    found = starts(axes, np.full(axes, 9.0))
    assert [is_nominal(each) for each in found] == nominal
    assert all(start.unit == pytest.approx(COST) for start in found)
