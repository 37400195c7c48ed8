"""Which gaits a plan tries beside its first one."""

from __future__ import annotations

import pytest

from gaitflow.runtime.atlas import NEAR_AXES, Atlas
from gaitflow.runtime.attempt import Effort
from gaitflow.runtime.rivals import (
    EVEN,
    FEW_AXES,
    GREAT_SAVING,
    LEAST_SAVING,
    LIKELY,
    LIKELY_FEW,
    LIKELY_WIDE,
    SURPRISE,
    SURPRISED,
    UNLIKELY,
    effort_for,
    likely,
    tried_below,
    unlikely,
)


def over(axes: int) -> Atlas:
    return Atlas.empty([f"axis {number}" for number in range(axes)])


@pytest.mark.parametrize(
    ("axes", "sure", "spared"),
    [(FEW_AXES, {0}, set()), (FEW_AXES + 1, {0, 5}, {4}), (NEAR_AXES + 1, {0, 5, 2, 3}, {4})],
)
def test_gaits_by_their_probability(axes: int, sure: set[int], spared: set[int]) -> None:
    chances = {
        0: LIKELY_FEW,
        5: LIKELY,
        3: LIKELY / 2,
        2: LIKELY_WIDE,
        6: LIKELY_WIDE / 2,
        1: UNLIKELY,
        4: UNLIKELY / 2,
    }
    assert (likely(over(axes), chances), unlikely(over(axes), chances)) == (sure, spared)


@pytest.mark.parametrize(
    ("axes", "cost", "share"),
    [
        (NEAR_AXES, SURPRISE * 2.0, 1 - LEAST_SAVING),
        (NEAR_AXES, SURPRISE * 2.1, SURPRISED),
        (NEAR_AXES + 1, SURPRISE * 2.1, 1 - LEAST_SAVING),
    ],
)
def test_where_a_cost_surprises_somewhat_dearer_gaits_are_tried(axes: int, cost: float, share: float) -> None:
    assert tried_below(over(axes), 2.0, cost) == share


def test_what_may_save_much_is_tried_harder() -> None:
    assert effort_for(10 * (1 - GREAT_SAVING), 10.0) is Effort.RIVAL
    assert effort_for(9.9 * (1 - GREAT_SAVING), 10.0) is Effort.PROMISING


@pytest.mark.parametrize("least", [9.0, 0.1, 99.0])
def test_what_is_as_likely_the_best_as_not_is_tried_as_hard_as_the_first(least: float) -> None:
    assert effort_for(least, 10.0, EVEN) is Effort.FIRST
    assert effort_for(least, 10.0, 0.99 * EVEN) is effort_for(least, 10.0)
