"""Pattern space: where a search begins and where it goes from a pattern.

Local moves change one thing about a contact schedule: one leg's contact in one phase (flip), one leg's timing (shift),
or where the schedule spends its phases (merge one into its predecessor and split another).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from gaitflow.core.gaits import NO_SYMMETRY, Pattern, Symmetry, representative


def library(legs: int, phases: int, symmetry: Symmetry = NO_SYMMETRY) -> tuple[Pattern, ...]:
    """The gaits in which all legs have one duty factor and one stance, at every offset: walks, trots, paces, bounds.

    Representatives, longest stances first: whoever stops early has seen the walks. For 4 legs and 4 phases 108
    patterns; of few phases the archetypes that Fig. 5 and 8 vary.
    """
    found: set[Pattern] = set()
    for stance in range(1, phases):
        row = "1" * stance + "0" * (phases - stance)
        for offsets in product(range(phases), repeat=legs - 1):
            found.add(representative(Pattern(tuple(row[cut:] + row[:cut] for cut in (0, *offsets))), symmetry))
    return tuple(sorted(found, key=lambda pattern: (-pattern.rows[0].count("1"), pattern)))


def neighbours(
    pattern: Pattern, stances_per_leg: int | None = None, symmetry: Symmetry = NO_SYMMETRY
) -> tuple[Pattern, ...]:
    """Representatives of all patterns one local move away in which a leg stands, sorted; never the pattern itself."""
    views = {
        representative(moved, symmetry)
        for moved in (*_flips(pattern), *_shifts(pattern), *_merges_and_splits(pattern))
        if any("1" in row for row in moved.rows) and _allowed(moved, stances_per_leg)
    }
    return tuple(sorted(views - {representative(pattern, symmetry)}))


def standing(legs: int, phases: int) -> Pattern:
    """All legs stand all the time."""
    return Pattern(("1" * phases,) * legs)


def doubled(pattern: Pattern) -> Pattern:
    """The same contact schedule in twice as many phases."""
    return Pattern(tuple("".join(digit * 2 for digit in row) for row in pattern.rows))


def repeated(pattern: Pattern) -> Pattern:
    """The contact schedule twice over: two strides a cycle."""
    return Pattern(tuple(row * 2 for row in pattern.rows))


def _allowed(pattern: Pattern, stances_per_leg: int | None) -> bool:
    return stances_per_leg is None or all(pattern.touchdowns(leg) == stances_per_leg for leg in range(pattern.legs))


def _flips(pattern: Pattern) -> Iterator[Pattern]:
    for leg, row in enumerate(pattern.rows):
        for phase, digit in enumerate(row):
            yield _with_row(pattern, leg, row[:phase] + ("0" if digit == "1" else "1") + row[phase + 1 :])


def _shifts(pattern: Pattern) -> Iterator[Pattern]:
    for leg, row in enumerate(pattern.rows):
        yield _with_row(pattern, leg, row[1:] + row[:1])
        yield _with_row(pattern, leg, row[-1:] + row[:-1])


def _merges_and_splits(pattern: Pattern) -> Iterator[Pattern]:
    for merged, split in product(range(pattern.phases), repeat=2):
        if merged != split:
            kept = [phase for phase in range(pattern.phases) if phase != merged]
            order = [phase for one in kept for phase in ([one, one] if one == split else [one])]
            yield Pattern(tuple("".join(row[phase] for phase in order) for row in pattern.rows))


def _with_row(pattern: Pattern, leg: int, row: str) -> Pattern:
    return Pattern((*pattern.rows[:leg], row, *pattern.rows[leg + 1 :]))
