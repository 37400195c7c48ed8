from __future__ import annotations

import pytest

from benchmarks.search.pattern_count import count_patterns
from gaitflow.core.gaits import NO_SYMMETRY, Symmetry, all_patterns

PAIRS = Symmetry(mirror=(1, 0, 3, 2))
FACING = Symmetry(mirror=(1, 0, 3, 2), reversal=(2, 3, 0, 1))


@pytest.mark.parametrize("stances", [1, None])
@pytest.mark.parametrize(
    ("legs", "phases", "symmetry"),
    [
        (2, 4, NO_SYMMETRY),
        (2, 5, Symmetry(mirror=(1, 0))),
        (2, 6, Symmetry(reversal=(1, 0))),
        (2, 5, Symmetry(reversal=(0, 1))),
        (3, 4, Symmetry(mirror=(0, 2, 1))),
        (4, 3, PAIRS),
        (4, 4, FACING),
    ],
)
def test_as_many_as_are_listed(legs: int, phases: int, symmetry: Symmetry, stances: int | None) -> None:
    assert count_patterns(legs, phases, stances, symmetry) == len(all_patterns(legs, phases, stances, symmetry))


def test_known_numbers() -> None:
    assert count_patterns(4, 4, 1, PAIRS) == 2628
    free = count_patterns(4, 8, None, PAIRS)
    assert 2**32 / 16 < free < 2**32 / 16 * 1.001
    assert count_patterns(4, 8, 1, PAIRS) == (56**4 + 2 * 56**2) // 16
