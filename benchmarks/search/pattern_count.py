"""How many patterns there are, by Burnside's lemma: also where there are far too many to list."""

from __future__ import annotations

import math
from collections.abc import Sequence


def count_patterns(legs: int, phases: int, stances_per_leg: int | None, mirror: Sequence[int] | None) -> int:
    """The patterns of `gaits.all_patterns`, counted: up to where the cycle is cut and, with `mirror`, left and right.

    `stances_per_leg` is 1 or None for any number. The mean over the symmetries of how many patterns each leaves as
    they are: along a cycle of c legs that swap, one row repeats, and must itself be the same c rotations later.
    """
    views = [range(legs)] if mirror is None else [range(legs), mirror]
    kept = sum(
        math.prod(_rows_kept(phases, turn * length, stances_per_leg) for length in _cycle_lengths(view))
        for view in views
        for turn in range(phases)
    )
    return kept // (len(views) * phases)


def _rows_kept(phases: int, turn: int, stances_per_leg: int | None) -> int:
    """Rows of one leg that rotating by `turn` phases leaves as they are."""
    if stances_per_leg is None:
        return int(2 ** math.gcd(turn, phases))
    return phases * (phases - 1) if turn % phases == 0 else 0


def _cycle_lengths(permutation: Sequence[int]) -> list[int]:
    lengths, left = [], set(range(len(permutation)))
    while left:
        leg, length = left.pop(), 1
        while (leg := permutation[leg]) in left:
            left.remove(leg)
            length += 1
        lengths.append(length)
    return lengths
