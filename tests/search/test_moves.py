from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from gaitflow.core.gaits import Pattern, Symmetry, all_patterns, gait_of, representative
from gaitflow.search.moves import doubled, library, neighbours, repeated

MIRROR = Symmetry(mirror=(1, 0, 3, 2))
ONE_STANCE = all_patterns(4, 4, 1, MIRROR)
patterns = st.sampled_from(ONE_STANCE)


def test_the_library_holds_the_archetypes() -> None:
    found = library(4, 4, MIRROR)
    assert len(found) == 108
    assert set(found) <= set(ONE_STANCE)
    for text in (
        "0111/1101/1011/1110",  # walks in which one leg swings at a time, in either order
        "0111/1101/1110/1011",
        "0011/1100/1100/0011",  # trot
        "0001/0100/0100/0001",  # running trot
        "0011/1100/0011/1100",  # pace
        "0011/0011/1100/1100",  # bound
        "0011/0011/0011/0011",  # pronk
    ):
        assert representative(Pattern.from_text(text), MIRROR) in found, text


def test_the_plane_s_library_is_small() -> None:
    assert len(library(2, 4)) == 12
    assert all(row.count("1") == pattern.rows[0].count("1") for pattern in library(2, 4) for row in pattern.rows)


@given(patterns)
def test_moves_stay_among_the_allowed_patterns(pattern: Pattern) -> None:
    near = neighbours(pattern, 1, MIRROR)
    assert pattern not in near
    assert list(near) == sorted(set(near))
    assert set(near) <= set(ONE_STANCE)
    assert 5 <= len(near) <= 16 + 8 + 12
    assert all("1" in one.text for one in neighbours(pattern, None, MIRROR))
    assert set(near) <= set(neighbours(pattern, None, MIRROR))


@given(patterns, st.integers(0, 3), st.booleans())
def test_neither_cut_nor_mirror_changes_where_one_can_go(pattern: Pattern, cut: int, mirrored: bool) -> None:
    view = pattern.rotated(cut)
    view = view.mirrored((1, 0, 3, 2)) if mirrored else view
    assert neighbours(view, 1, MIRROR) == neighbours(pattern, 1, MIRROR)


@given(patterns)
def test_every_move_can_be_taken_back(pattern: Pattern) -> None:
    """Flips and shifts undo themselves; a merged phase that had no equal neighbour is gone for good."""
    for near in neighbours(pattern, 1, MIRROR):
        if gait_of(near, MIRROR).phases >= gait_of(pattern, MIRROR).phases:
            assert pattern in neighbours(near, 1, MIRROR)


def test_all_one_stance_patterns_can_be_reached_from_the_library() -> None:
    reached, front = set(library(4, 4, MIRROR)), set(library(4, 4, MIRROR))
    while front:
        front = {near for pattern in front for near in neighbours(pattern, 1, MIRROR)} - reached
        reached |= front
    assert reached == set(ONE_STANCE)


@given(patterns)
def test_doubling_keeps_the_gait(pattern: Pattern) -> None:
    twice = doubled(pattern)
    assert twice.phases == 8
    assert gait_of(twice, MIRROR) == gait_of(pattern, MIRROR)


@given(patterns)
def test_repeating_makes_two_strides(pattern: Pattern) -> None:
    twice = repeated(pattern)
    assert twice.phases == 8
    assert all(twice.touchdowns(leg) == 2 * pattern.touchdowns(leg) for leg in range(4))
