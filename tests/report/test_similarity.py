"""How alike the motions of a region are, on loops whose likeness is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from gaitflow.report.similarity import alikeness, scaled_shape, similar_shapes
from gaitflow.search.solution import Solution

SHAPES = 4  # height and pitch, and their rates


@pytest.fixture
def region(solution_of) -> Callable[[Sequence[float]], list[Solution]]:
    """A sine in every coordinate, of each of these amplitudes."""

    def make(amplitudes: Sequence[float]) -> list[Solution]:
        made = []
        for amplitude in amplitudes:
            one = solution_of(1.1, 0.6, "gallop")
            base = one.trajectory.base.copy()
            cycle = np.sin(2 * np.pi * np.arange(len(base)) / len(base))
            base[:, [1, 2, 4, 5]] = 0.5 + amplitude * cycle[:, None]
            made.append(replace(one, trajectory=replace(one.trajectory, base=base)))
        return made

    return make


def test_one_shape_in_many_sizes(region) -> None:
    like = alikeness(region([1.0, 2.0, 4.0]))
    assert like is not None
    assert like.correlations == pytest.approx(np.ones((3, SHAPES))) and like.alike == 3 * SHAPES
    assert like.scale == pytest.approx(3.6 / 1.2)
    assert scaled_shape("gallop", {"gallop": region([1.0, 2.0, 4.0])})[0] == "holds"


def test_motions_of_one_size_do_not_change_their_scale(region) -> None:
    verdict, text = scaled_shape("gallop", {"gallop": region([1.0, 1.0, 1.1])})
    assert verdict == "does not" and "1.1 times the smallest" in text


def test_the_other_way_round_is_another_shape(region) -> None:
    verdict, text = similar_shapes({"gallop": region([3.0, 2.0, -1.0]), "walking": []})
    assert verdict == "holds in part" and text.startswith("8 of 12 loops (67%)")


def test_a_body_that_is_still_has_no_shape(region) -> None:
    like = alikeness(region([0.0, 1.0, 1.0]))
    assert like is not None and np.all(like.correlations[0] == 0.0) and like.alike == 2 * SHAPES


def test_two_motions_are_no_region(region) -> None:
    assert alikeness(region([1.0, 1.0])) is None and alikeness([]) is None
    assert scaled_shape("gallop", {})[0] == "not measured"
    assert similar_shapes({"gallop": region([1.0, 1.0])})[0] == "not measured"
