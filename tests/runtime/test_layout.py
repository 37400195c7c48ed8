from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

from gaitflow.core.layout import Layout as ProblemLayout
from gaitflow.publishing import Parts
from gaitflow.runtime.layout import Layout, unpack


def _same(theirs: ProblemLayout, mine: Layout, cycle: float) -> None:
    w = np.random.default_rng(0).normal(size=theirs.nw)
    expected, found = theirs.unpack(w, cycle), unpack(mine, theirs.scale(1.0), w, cycle)
    for field in fields(expected):
        np.testing.assert_allclose(getattr(found, field.name), getattr(expected, field.name), rtol=1e-14, atol=1e-14)


@pytest.mark.parametrize("cycle", [0.4, 1.0, 1.7])
def test_unpacks_as_the_problem_does_in_the_plane(parts: Parts, cycle: float) -> None:
    theirs = parts.problem.layout
    _same(theirs, Layout(4, 4, ("F", "H"), 2, theirs.nb, parts.problem.ng), cycle)


def test_unpacks_as_the_problem_does_in_space() -> None:
    theirs = ProblemLayout(dimension=3, legs=4, phases=4, knots_per_phase=10, weight=299.0)
    mine = Layout(4, 10, ("LF", "RF", "LH", "RH"), 3, 12, 1)
    assert mine.variables == theirs.nw == 1948
    _same(theirs, mine, 0.8)


def test_durations_are_the_last_variables() -> None:
    layout = Layout(4, 10, ("F", "H"), 2, 6, 1)
    assert layout.variables == 734
    assert layout.duration_slice == (730, 734)
