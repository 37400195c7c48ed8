"""How many patterns there are, by Burnside's lemma: also where there are far too many to list."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

from gaitflow.core.gaits import NO_SYMMETRY, Pattern, Symmetry


def count_patterns(legs: int, phases: int, stances_per_leg: int | None, symmetry: Symmetry = NO_SYMMETRY) -> int:
    """The patterns of `gaits.all_patterns`, counted: up to where the cycle is cut and to the symmetry's images.

    The mean over the symmetries of how many patterns each leaves as they are: along a cycle of c legs that take each
    other's place one row decides the others, and must be itself after c turns and reversals.
    """
    rows = ["".join(row) for row in product("01", repeat=phases)]
    rows = [row for row in rows if stances_per_leg in (None, Pattern((row,)).touchdowns(0))]
    same, mirror = tuple(range(legs)), symmetry.mirror
    views = [(same, False)] if mirror is None else [(same, False), (mirror, False)]
    if symmetry.reversal is not None:
        views += [(tuple(symmetry.reversal[leg] for leg in legs_of), True) for legs_of, _ in views]
    kept = sum(
        math.prod(_rows_kept(rows, turn, backwards, length) for length in _cycle_lengths(view))
        for view, backwards in views
        for turn in range(phases)
    )
    return kept // (len(views) * phases)


def _rows_kept(rows: Sequence[str], turn: int, backwards: bool, times: int) -> int:
    """How many rows are as they were when they are reversed or not, and then turned, so many times."""

    def moved(row: str) -> str:
        for _ in range(times):
            row = row[::-1] if backwards else row
            row = row[turn:] + row[:turn]
        return row

    return sum(moved(row) == row for row in rows)


def _cycle_lengths(permutation: Sequence[int]) -> list[int]:
    lengths, left = [], set(range(len(permutation)))
    while left:
        leg, length = left.pop(), 1
        while (leg := permutation[leg]) in left:
            left.remove(leg)
            length += 1
        lengths.append(length)
    return lengths
