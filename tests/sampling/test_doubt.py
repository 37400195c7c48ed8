"""Searches go where the pick may be wrong: where costs cross, where nothing is known, and where it was wrong before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from sheets import STEPS, atlas, sheet_of

from gaitflow.runtime.atlas import Atlas
from gaitflow.sampling.doubt import WORST, next_places, possible_regret

LOW, HIGH = np.zeros(2), 4 * STEPS

BOTH = {0, 1}  # gaits that a map picks from


def two_gaits(difference: Callable[[float], float], slope: Callable[[float], float]) -> Atlas:
    """Two gaits whose costs' logarithms differ by a function of the place on the first axis, in steps."""
    level = sheet_of(lambda x, y: 0.0, lambda x, y: (0.0, 0.0))
    other = sheet_of(lambda x, y: difference(x), lambda x, y: (slope(x), 0.0), gait=1)
    return atlas(level, other)


def test_a_gait_that_is_dearer_by_far_leaves_no_doubt() -> None:
    clear = two_gaits(lambda x: 1.0, lambda x: 0.0)
    assert possible_regret(clear, 2.1 * STEPS, BOTH) == 0.0


def test_where_nothing_is_known_the_pick_may_be_anything() -> None:
    assert possible_regret(two_gaits(lambda x: 1.0, lambda x: 0.0), 40 * STEPS, BOTH) == WORST


def test_nodes_that_disagree_make_a_crossing_doubtful() -> None:
    crossing = two_gaits(lambda x: x - 2.0, lambda x: 1.0)
    assert possible_regret(crossing, np.array([2.0, 2.0]) * STEPS, BOTH) == pytest.approx(0.0, abs=1e-6), (
        "both are sure"
    )
    kinked = two_gaits(lambda x: abs(x - 2.5) - 0.2, lambda x: 1.0 if x > 2.5 else -1.0)
    assert possible_regret(kinked, np.array([2.3, 2.0]) * STEPS, BOTH) > 0.01


def test_places_lie_apart_inside_the_box_and_repeat() -> None:
    made, searched = two_gaits(lambda x: 1.0, lambda x: 0.0), np.array([[1.0, 1.0]]) * STEPS
    places = np.array(next_places(made, BOTH, searched, np.zeros(1), LOW, HIGH, 8, seed=3))
    assert ((places >= LOW) & (places <= HIGH)).all()
    both = np.vstack([places, searched]) / STEPS
    apart = np.linalg.norm(both[:, None] - both[None], axis=2)[~np.eye(len(both), dtype=bool)]
    assert apart.min() > 0.8, "eight places fill a box of four steps"
    again = next_places(made, BOTH, searched, np.zeros(1), LOW, HIGH, 8, seed=3)
    np.testing.assert_array_equal(places, again)


def test_regret_seen_near_by_draws_searches() -> None:
    made = two_gaits(lambda x: 1.0, lambda x: 0.0)
    searched = np.array([[x + 0.5, y + 0.5] for x in range(4) for y in range(4)]) * STEPS
    regrets = np.where((searched < 2 * STEPS).all(axis=1), 0.5, 0.0)
    places = np.array(next_places(made, BOTH, searched, regrets, LOW, HIGH, 4, seed=0))
    assert (places < 2.6 * STEPS).all(axis=1).sum() >= 3, "in the quarter where picks were wrong"


def test_an_edge_of_what_is_known_draws_searches() -> None:
    half = sheet_of(lambda x, y: 0.0, lambda x, y: (0.0, 0.0))
    made, searched = atlas(half), np.array([[2.0, 2.0]]) * STEPS
    places = np.array(next_places(made, BOTH, searched, np.zeros(1), LOW, 8 * STEPS, 6, seed=1))
    assert (places > 4.5 * STEPS).any(axis=1).sum() >= 5


def test_a_missing_gait_that_costs_less_is_a_regret() -> None:
    made = two_gaits(lambda x: 1.0, lambda x: 0.0)
    place = np.array([2.0, 2.0]) * STEPS
    assert possible_regret(made, place, {0}) == 0.0
    assert possible_regret(made, place, {1}) == WORST, "e times as dear as the gait that the map does not pick from"
