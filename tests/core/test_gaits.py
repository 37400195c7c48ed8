"""Symmetry and counts of gait patterns."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise, product

import pytest
from figure_5 import FIGURE_5
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.core.gaits import NO_SYMMETRY, Pattern, Symmetry, all_patterns, can_move, diagram, gait_of, representative

QUADRUPED = ("LF", "RF", "LH", "RH")
MIRROR = (1, 0, 3, 2)
SWAP = (2, 3, 0, 1)  # front and hind
LEFT_RIGHT = Symmetry(mirror=MIRROR)
SYMMETRIES = (NO_SYMMETRY, LEFT_RIGHT, Symmetry(reversal=SWAP), Symmetry(MIRROR, SWAP))


def patterns_of(legs: st.SearchStrategy[int]) -> st.SearchStrategy[Pattern]:
    """Patterns of 1 to 6 phases."""
    shapes = st.tuples(legs, st.integers(1, 6))
    return shapes.flatmap(
        lambda shape: st.tuples(*[st.text("01", min_size=shape[1], max_size=shape[1])] * shape[0]).map(Pattern)
    )


patterns = patterns_of(st.integers(1, 4))
quadruped_patterns = patterns_of(st.just(4))
planar_patterns = patterns_of(st.just(2))


def split(pattern: Pattern, phase: int) -> Pattern:
    """The same contacts with one phase cut in two."""
    return Pattern(tuple(row[: phase + 1] + row[phase:] for row in pattern.rows))


def contacts(pattern: Pattern, ticks: int) -> list[tuple[int, ...]]:
    """The cycle sampled on a clock, every phase lasting `ticks`."""
    return [pattern.column(phase) for phase in range(pattern.phases) for _ in range(ticks)]


@given(patterns)
def test_text_round_trip(pattern: Pattern) -> None:
    assert Pattern.from_text(pattern.text) == pattern
    assert pattern.text.count("/") == pattern.legs - 1


@pytest.mark.parametrize(
    "text", ["", "/", "0110/", "011/1100", "0112/1100", "0110 / 1100", "٠١/١٠", "F 01 / H 10", "0\n1"]
)
def test_text_that_is_no_pattern_is_refused_with_the_way_out(text: str) -> None:
    with pytest.raises(ValueError, match="such as 0110/1100") as caught:
        Pattern.from_text(text)
    assert repr(text) in str(caught.value)


def test_a_huge_text_is_not_repeated_in_the_error() -> None:
    with pytest.raises(ValueError) as caught:
        Pattern.from_text("2" * 1_000_000)
    assert len(str(caught.value)) < 300


def test_rotation_moves_the_cut() -> None:
    pattern = Pattern.from_text("0111/1101")
    assert pattern.rotated(1).text == "1110/1011"
    assert pattern.rotated(1).column(0) == pattern.column(1) == (1, 1)
    assert pattern.rotated(-1) == pattern.rotated(3)


@given(quadruped_patterns, st.integers(-10, 10))
def test_the_gait_does_not_depend_on_where_the_cycle_is_cut(pattern: Pattern, cut: int) -> None:
    for symmetry in SYMMETRIES:
        assert gait_of(pattern.rotated(cut), symmetry) == gait_of(pattern, symmetry)
        assert representative(pattern.rotated(cut), symmetry) == representative(pattern, symmetry)


@given(quadruped_patterns)
def test_the_gait_does_not_depend_on_left_and_right(pattern: Pattern) -> None:
    assert pattern.mirrored(MIRROR).mirrored(MIRROR) == pattern
    assert gait_of(pattern.mirrored(MIRROR), LEFT_RIGHT) == gait_of(pattern, LEFT_RIGHT)
    assert representative(pattern.mirrored(MIRROR), LEFT_RIGHT) == representative(pattern, LEFT_RIGHT)


@given(quadruped_patterns)
def test_a_pattern_run_backwards_is_the_same_gait_where_time_is_symmetric(pattern: Pattern) -> None:
    assert pattern.reversed(SWAP).reversed(SWAP) == pattern
    assert pattern.reversed(SWAP).column(0) == pattern.mirrored(SWAP).column(pattern.phases - 1)
    for symmetry in (Symmetry(reversal=SWAP), Symmetry(MIRROR, SWAP)):
        assert gait_of(pattern.reversed(SWAP), symmetry) == gait_of(pattern, symmetry)
        assert representative(pattern.reversed(SWAP), symmetry) == representative(pattern, symmetry)
    both = Symmetry(MIRROR, SWAP)
    assert gait_of(pattern.mirrored(MIRROR).reversed(SWAP).rotated(1), both) == gait_of(pattern, both)


@given(quadruped_patterns)
def test_more_symmetry_merges_more(pattern: Pattern) -> None:
    """A gait under two symmetries is the smallest of those under one: no merge is lost, and none is invented."""
    images = [pattern, pattern.mirrored(MIRROR), pattern.reversed(SWAP), pattern.mirrored(MIRROR).reversed(SWAP)]
    for symmetry, chosen in zip(SYMMETRIES, ((0,), (0, 1), (0, 2), (0, 1, 2, 3)), strict=True):
        assert gait_of(pattern, symmetry) == min(gait_of(images[i]) for i in chosen)


@given(quadruped_patterns, st.integers(1, 5))
def test_where_the_cut_counts_rotations_are_one_gait_of_several_patterns(pattern: Pattern, cut: int) -> None:
    fixed = Symmetry(MIRROR, rotation=False)
    assert gait_of(pattern.rotated(cut), fixed) == gait_of(pattern, LEFT_RIGHT)
    assert representative(pattern, fixed) == min(pattern, pattern.mirrored(MIRROR))


def test_counts_where_the_cut_counts() -> None:
    """12^2 patterns of a front and a hind leg with one stance each, instead of 36 up to rotation."""
    found = all_patterns(2, 4, 1, Symmetry(rotation=False))
    assert len(found) == 12**2
    assert {representative(pattern) for pattern in found} == set(all_patterns(2, 4, 1))


@pytest.mark.parametrize(("one", "other"), [("0111/1101", "0111/1101"), ("0011/0110", "0110/1100")])
def test_time_reversal_in_the_plane(one: str, other: str) -> None:
    """Front and hind swap: of a gallop with the flight before the front's stance comes one with it after."""
    swap = Symmetry(reversal=(1, 0))
    assert gait_of(Pattern.from_text(one).reversed((1, 0)), swap) == gait_of(Pattern.from_text(other), swap)


@given(patterns, st.data())
def test_the_gait_does_not_depend_on_split_phases(pattern: Pattern, data: st.DataObject) -> None:
    phase = data.draw(st.integers(0, pattern.phases - 1))
    assert gait_of(split(pattern, phase)) == gait_of(pattern)


@given(quadruped_patterns)
def test_canonical_forms_are_their_own(pattern: Pattern) -> None:
    for symmetry in SYMMETRIES:
        assert representative(representative(pattern, symmetry), symmetry) == representative(pattern, symmetry)
        assert gait_of(gait_of(pattern, symmetry), symmetry) == gait_of(pattern, symmetry)


@given(planar_patterns, planar_patterns)
def test_equal_gaits_are_equal_contacts(one: Pattern, other: Pattern) -> None:
    """Against a plain comparison that merges nothing: the sequence of distinct contacts from every cut."""

    def cycle(pattern: Pattern) -> list[tuple[int, ...]]:
        columns = contacts(pattern, 2)
        start = next((i for i in range(len(columns)) if columns[i] != columns[i - 1]), 0)
        turned = columns[start:] + columns[:start]
        return [turned[0]] + [after for before, after in pairwise(turned) if after != before]

    a, b = cycle(one), cycle(other)
    assert (gait_of(one) == gait_of(other)) == any(a[i:] + a[:i] == b for i in range(len(a)))


@given(patterns)
def test_merging_is_idempotent_and_leaves_no_equal_neighbours(pattern: Pattern) -> None:
    merged = pattern.merged()
    assert merged.merged() == merged
    columns = [merged.column(i) for i in range(merged.phases)]
    assert len(columns) == 1 or all(columns[i] != columns[i - 1] for i in range(len(columns)))
    assert {pattern.column(i) for i in range(pattern.phases)} == set(columns)


def test_merging_joins_the_last_phase_to_the_first() -> None:
    assert Pattern.from_text("0110/0100").merged().text == "110/100"
    assert Pattern.from_text("1111/0000").merged().text == "1/0"


@given(patterns)
def test_touchdowns_survive_rotation_and_merging(pattern: Pattern) -> None:
    for leg in range(pattern.legs):
        assert pattern.touchdowns(leg) == pattern.rotated(2).touchdowns(leg) == pattern.merged().touchdowns(leg)


def test_touchdowns_are_counted_round_the_cycle() -> None:
    pattern = Pattern.from_text("0101/1001/1111/0000")
    assert [pattern.touchdowns(leg) for leg in range(4)] == [2, 1, 0, 0]


@pytest.mark.parametrize("permutation", [(0, 1, 2), (0, 0, 2, 3), (1, 2, 3, 0), (4, 1, 2, 3)])
def test_a_mirror_that_is_none_is_refused(permutation: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"in pairs that swap"):
        Pattern.from_text("01/01/10/10").mirrored(permutation)


def test_counts_in_the_plane() -> None:
    everything = {Pattern((front, hind)) for front in rows(4) for hind in rows(4)}
    assert len(everything) == 256
    found = all_patterns(2, 4)
    assert len(found) == 70
    assert list(found) == sorted(found)
    assert set(found) == {representative(pattern) for pattern in everything}
    single = all_patterns(2, 4, stances_per_leg=1)
    assert len(single) == 36
    assert set(single) == {pattern for pattern in found if pattern.touchdowns(0) == pattern.touchdowns(1) == 1}


def rows(phases: int) -> list[str]:
    """All rows of one leg."""
    return ["".join(row) for row in product("01", repeat=phases)]


def test_counts_of_a_quadruped() -> None:
    found = all_patterns(4, 4)
    assert len(found) == 16_456
    mirrored = all_patterns(4, 4, symmetry=LEFT_RIGHT)
    assert set(mirrored) == {representative(pattern, LEFT_RIGHT) for pattern in found}
    single = all_patterns(4, 4, stances_per_leg=1, symmetry=LEFT_RIGHT)
    assert len(single) == 2_628
    assert all(pattern.touchdowns(leg) == 1 for pattern in single for leg in range(4))


@pytest.mark.parametrize(("legs", "phases", "stances"), [(4, 8, None), (2, 10_000, 1), (4, 8, 1)])
def test_too_many_patterns_are_refused_before_they_are_made(legs: int, phases: int, stances: int | None) -> None:
    with pytest.raises(ValueError, match=f"{legs} legs in {phases} phases have more than"):
        all_patterns(legs, phases, stances)


@pytest.mark.parametrize(("legs", "phases"), [(0, 4), (2, 0), (-1, 4)])
def test_patterns_need_legs_and_phases(legs: int, phases: int) -> None:
    with pytest.raises(ValueError, match="at least 1 of each"):
        all_patterns(legs, phases, 1)


@pytest.mark.parametrize("text", ["0000/0000", "1111/0110", "1111/1111", "0/0", "0110/1111"])
def test_patterns_that_cannot_move(text: str) -> None:
    assert not can_move(Pattern.from_text(text))


def test_every_pattern_of_the_figure_can_move() -> None:
    assert all(can_move(Pattern(rows)) for rows in FIGURE_5.values())
    assert can_move(Pattern.from_text("0000/0110")), "one leg may hop alone"


def test_diagram() -> None:
    assert diagram(Pattern.from_text("0111/1101"), ("F", "H")) == "F 0111 / H 1101"
    with pytest.raises(ValueError, match="0111/1101 has 2 legs, but the names are F"):
        diagram(Pattern.from_text("0111/1101"), ("F",))


def test_a_pattern_needs_only_the_standard_library() -> None:
    """The runtime stands on it."""
    code = (
        "import sys, gaitflow; before = set(sys.modules); import gaitflow.core.gaits; "
        "print({name.split('.')[0] for name in set(sys.modules) - before} - sys.stdlib_module_names - {'gaitflow'})"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "set()"
