from __future__ import annotations

import pytest

from benchmarks.search.pattern_count import count_patterns
from gaitflow.core.gaits import all_patterns

PAIRS = (1, 0, 3, 2)


@pytest.mark.parametrize("stances", [1, None])
@pytest.mark.parametrize(
    ("legs", "phases", "mirror"),
    [(1, 5, None), (2, 3, None), (2, 4, None), (2, 6, None), (2, 4, (1, 0)), (3, 4, (0, 2, 1)), (4, 3, PAIRS),
     (4, 4, PAIRS), (4, 4, None)],
)  # fmt: skip
def test_as_many_as_are_listed(legs: int, phases: int, mirror: tuple[int, ...] | None, stances: int | None) -> None:
    assert count_patterns(legs, phases, stances, mirror) == len(all_patterns(legs, phases, stances, mirror))


def test_eight_phases_that_nobody_can_list() -> None:
    free = count_patterns(4, 8, None, PAIRS)
    assert 16**8 / 16 < free < 16**8 / 15
    assert count_patterns(4, 8, 1, PAIRS) == (56**4 + 2 * 56**2) // 16
