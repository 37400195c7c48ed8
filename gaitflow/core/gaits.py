"""Gait patterns: which leg stands in which phase, and when two patterns are one gait.

A pattern is Lambda of section III.A, one row of binaries a leg and one column a phase (1 = stance). Neither where the
cycle is cut, nor a phase split in two, nor an image under a symmetry of robot and task makes another gait, so the
canonical gait merges equal neighbouring phases and takes the smallest of all rotations and images. Several patterns may
realise one gait at different costs; those that cannot differ have one representative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from reprlib import repr as short

MAX_ENUMERATED = 1 << 20  # patterns that all_patterns looks at, before symmetry reduces them


@dataclass(frozen=True)
class Symmetry:
    """Under which images a pattern stays the same gait, and has the same cost.

    mirror: the permutation of the legs in a left-right mirror image (`Robot.mirror_permutation`), None where left and
    right are told apart. reversal: that of the body facing the other way (`Robot.reversal_permutation`), None where a
    motion run backwards is another one. rotation: whether the cycle may be cut anywhere, False while the body speeds
    up: its rotations stay one gait, but they are other motions, each with a cost of its own.
    """

    mirror: tuple[int, ...] | None = None
    reversal: tuple[int, ...] | None = None
    rotation: bool = True


NO_SYMMETRY = Symmetry()


@dataclass(frozen=True, order=True)
class Pattern:
    """Contacts over one cycle: a string of 0 (swing) and 1 (stance) a leg, a digit a phase; ordered row by row.

    Raises ValueError when there is no leg or phase, rows differ in length, or a digit is neither 0 nor 1.
    """

    rows: tuple[str, ...]

    def __post_init__(self) -> None:
        lengths = {len(row) for row in self.rows}
        if len(lengths) != 1 or 0 in lengths or any(row.strip("01") for row in self.rows):
            raise ValueError(
                f"gait pattern {short('/'.join(self.rows))}: write a row of digits 0 (swing) or 1 (stance) for each "
                "leg, all of one length, joined by '/', such as 0110/1100"
            )

    @classmethod
    def from_text(cls, text: str) -> Pattern:
        """The pattern that `text` writes, such as "0110/1100". Raises ValueError as the class does."""
        return cls(tuple(text.split("/")))

    @property
    def text(self) -> str:
        """The rows joined by "/", the form in which patterns are stored."""
        return "/".join(self.rows)

    @property
    def legs(self) -> int:
        """Number of legs."""
        return len(self.rows)

    @property
    def phases(self) -> int:
        """Number of phases."""
        return len(self.rows[0])

    def column(self, phase: int) -> tuple[int, ...]:
        """Contacts [legs] in one phase."""
        return tuple(int(row[phase]) for row in self.rows)

    def rotated(self, phases: int) -> Pattern:
        """The same cycle cut `phases` later: phase `phases` (modulo their number) becomes the first."""
        cut = phases % self.phases
        return Pattern(tuple(row[cut:] + row[:cut] for row in self.rows))

    def mirrored(self, permutation: Sequence[int]) -> Pattern:
        """The pattern whose leg i does what leg permutation[i] does here.

        Raises ValueError unless mirroring twice gives every leg back.
        """
        legs = list(range(self.legs))
        if sorted(permutation) != legs or [permutation[partner] for partner in permutation] != legs:
            raise ValueError(
                f"mirror {tuple(permutation)}: name the partner of each of the legs 0 to {self.legs - 1}, "
                "in pairs that swap, a leg that stays being its own partner"
            )
        return Pattern(tuple(self.rows[leg] for leg in permutation))

    def reversed(self, permutation: Sequence[int]) -> Pattern:
        """The pattern run backwards, whose leg i does what leg permutation[i] does here. Raises as `mirrored`."""
        return Pattern(tuple(row[::-1] for row in self.mirrored(permutation).rows))

    def merged(self) -> Pattern:
        """Without the phases that repeat their cyclic predecessor: the first phase follows the last."""
        columns = list(zip(*self.rows, strict=True))
        kept = [column for i, column in enumerate(columns) if column != columns[i - 1]] or columns[:1]
        return Pattern(tuple("".join(row) for row in zip(*kept, strict=True)))

    def touchdowns(self, leg: int) -> int:
        """How often a cycle the leg goes from swing to stance: 0 for a leg that always or never stands."""
        return _touchdowns(self.rows[leg])


def _touchdowns(row: str) -> int:
    return (row[-1] + row).count("01")


def _images(pattern: Pattern, symmetry: Symmetry) -> set[Pattern]:
    views = [pattern]
    if symmetry.mirror is not None:
        views += [view.mirrored(symmetry.mirror) for view in views]
    if symmetry.reversal is not None:
        views += [view.reversed(symmetry.reversal) for view in views]
    return {view.rotated(cut) for view in views for cut in range(pattern.phases if symmetry.rotation else 1)}


def representative(pattern: Pattern, symmetry: Symmetry = NO_SYMMETRY) -> Pattern:
    """The smallest of the patterns that are its equals in cost: rotations and images, all phases kept."""
    return min(_images(pattern, symmetry))


def gait_of(pattern: Pattern, symmetry: Symmetry = NO_SYMMETRY) -> Pattern:
    """The canonical gait: equal for two patterns exactly when they differ by cut, split phases or an image."""
    return representative(pattern.merged(), replace(symmetry, rotation=True))


def all_patterns(
    legs: int, phases: int, stances_per_leg: int | None = None, symmetry: Symmetry = NO_SYMMETRY
) -> tuple[Pattern, ...]:
    """Representatives of all patterns, sorted; with `stances_per_leg` those where each leg touches down so often.

    Raises ValueError when there are more than MAX_ENUMERATED to look at: 2^(legs * phases) without `stances_per_leg`.
    """
    if legs < 1 or phases < 1:
        raise ValueError(f"{legs} legs in {phases} phases have no pattern: take at least 1 of each")
    too_many = f"{legs} legs in {phases} phases have more than {MAX_ENUMERATED} patterns: take fewer phases or 1 stance"
    if phases > MAX_ENUMERATED.bit_length() - 1:
        raise ValueError(too_many)
    rows = ["".join(row) for row in product("01", repeat=phases)]
    rows = [row for row in rows if stances_per_leg in (None, _touchdowns(row))]
    if len(rows) ** legs > MAX_ENUMERATED:
        raise ValueError(too_many)
    seen: set[Pattern] = set()
    found = []
    for choice in product(rows, repeat=legs):
        pattern = Pattern(choice)
        if pattern not in seen:  # product counts upwards, so the first one met of an orbit is its smallest
            found.append(pattern)
            seen |= _images(pattern, symmetry)
    return tuple(found)


def can_move(pattern: Pattern) -> bool:
    """Whether a periodic gait with speed v > 0 is possible at all: a necessary condition.

    A leg that never swings cannot advance (7d), and a body that no leg ever carries falls.
    """
    return all("0" in row for row in pattern.rows) and any("1" in row for row in pattern.rows)


def diagram(pattern: Pattern, leg_names: Sequence[str]) -> str:
    """The pattern as Fig. 5 draws it, on one line: "F 0111 / H 1101".

    Raises ValueError when there is not one name a leg.
    """
    if len(leg_names) != pattern.legs:
        raise ValueError(f"{pattern.text} has {pattern.legs} legs, but the names are {', '.join(leg_names)}")
    return " / ".join(f"{name} {row}" for name, row in zip(leg_names, pattern.rows, strict=True))
