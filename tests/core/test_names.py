"""Names and kinds of gaits: Fig. 5 in the plane, Fig. 8 for quadrupeds, one name to one gait."""

from __future__ import annotations

from functools import cache
from itertools import permutations

import pytest
from figure_5 import FIGURE_5
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.core.gaits import Pattern, Symmetry, all_patterns, gait_of
from gaitflow.core.names import gait_kind, gait_name, leg_place, quadruped_places

LEGS = ("LF", "RF", "LH", "RH")
MIRROR = (1, 0, 3, 2)
LEFT_RIGHT = Symmetry(mirror=MIRROR)
ARCHETYPES = {  # LF, RF, LH, RH
    "pronk": "0110/0110/0110/0110",
    "trot": "0011/1100/1100/0011",
    "walking trot": "0111/1101/1101/0111",
    "running trot": "1000/0010/0010/1000",
    "pace": "0011/1100/0011/1100",
    "walking pace": "0111/1101/0111/1101",
    "running pace": "1000/0010/1000/0010",
    "bound": "1000/1000/0010/0010",
    "walking bound": "0111/0111/1101/1101",
    "four-beat walk": "1011/1110/0111/1101",  # swing: LH, LF, RH, RF
}
KINDS = {  # gaits that no kind is named after
    "walking trot": "011/110/110/011",
    "running trot": "0100/0110/0110/0100",
    "walking pace": "0111/1001/0111/1001",
    "bound": "0110/0110/1100/1100",
    "walking bound": "0011/0011/1100/1100",
    "four-beat walk": "1011/1101/1110/0111",  # diagonal sequence
    "three-beat walk": "0011/1110/1011/1101",
    "two-beat walk": "0111/1101/1101/0110",  # a walking trot but for one leg that lands with its pair and lifts first
    "one-beat run": "0100/0110/0110/0110",  # a pronk but for one leg
    "two-beat run": "0110/0100/1100/1000",
    "three-beat run": "1100/0010/0110/1000",
    "canter": "01100/00110/11000/01100",  # RH is 01100: LH, then LF and RH, then RF
    "gallop": "001100/000110/011000/110000",
}


def split(pattern: Pattern, phase: int) -> Pattern:
    """The same contacts with one phase cut in two."""
    return Pattern(tuple(row[: phase + 1] + row[phase:] for row in pattern.rows))


@cache
def single_stance_gaits() -> tuple[Pattern, ...]:
    """The canonical gaits of a quadruped in four phases where each leg touches down once."""
    patterns = all_patterns(4, 4, stances_per_leg=1, symmetry=LEFT_RIGHT)
    return tuple(sorted({gait_of(pattern, LEFT_RIGHT) for pattern in patterns}))


quadruped_patterns = st.integers(1, 8).flatmap(
    lambda phases: st.tuples(*[st.text("01", min_size=phases, max_size=phases)] * 4).map(Pattern)
)


@pytest.mark.parametrize(("name", "rows"), FIGURE_5.items())
def test_names_of_figure_5(name: str, rows: tuple[str, str]) -> None:
    pattern = Pattern(rows)
    assert gait_name(pattern, ("F", "H")) == gait_kind(pattern, ("F", "H")) == name
    for same in (pattern.rotated(1), split(pattern, 0), gait_of(pattern)):
        assert gait_name(same, ("F", "H")) == name
    assert gait_name(Pattern(rows[::-1]), ("H", "F")) == name, "the legs' order does not matter"


def test_running_the_figure_backwards_or_swapping_its_legs_is_another_gait() -> None:
    assert gait_name(Pattern.from_text("1100/0110"), ("F", "H")) == "F 0011 / H 1001"
    assert gait_name(Pattern.from_text("110/010"), ("F", "H")) == "F 011 / H 001"
    assert gait_name(Pattern.from_text("0110/0110"), ("F", "H")) == "F 01 / H 01"


@pytest.mark.parametrize("leg_names", [("F", "H"), ("H", "F"), ("A", "B")])
def test_planar_names_are_one_to_one(leg_names: tuple[str, str]) -> None:
    gaits = {gait_of(pattern) for phases in range(1, 7) for pattern in all_patterns(2, phases)}
    assert len({gait_name(gait, leg_names) for gait in gaits}) == len(gaits) > 200


@pytest.mark.parametrize(("kind", "text"), ARCHETYPES.items())
def test_an_archetype_goes_by_its_kind(kind: str, text: str) -> None:
    pattern = Pattern.from_text(text)
    assert gait_kind(pattern, LEGS) == gait_name(pattern, LEGS) == kind


@pytest.mark.parametrize(("kind", "text"), KINDS.items())
def test_another_gait_of_a_kind_shows_its_contacts(kind: str, text: str) -> None:
    pattern = Pattern.from_text(text)
    assert gait_kind(pattern, LEGS) == kind
    assert gait_name(pattern, LEGS) == f"{kind} {gait_of(pattern, LEFT_RIGHT).text}"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("1000/0000/0000/1000", "one-beat run"),
        ("01/00/01/00", "one-beat run"),
        ("00/00/10/10", "one-beat run"),
        ("0/0/1/1", "no-beat walk"),
        ("1/0/0/1", "no-beat walk"),
        ("11/01/01/11", "one-beat walk"),
    ],
)
def test_a_pair_of_legs_that_never_lands_makes_no_pair_kind(text: str, kind: str) -> None:
    pattern = Pattern.from_text(text)
    assert gait_kind(pattern, LEGS) == kind
    assert gait_name(pattern, LEGS) == f"{kind} {gait_of(pattern, LEFT_RIGHT).text}"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("0001/0100/0010/1000", "four-beat grounded run"),  # one leg down at a time: they stand for a quarter
        ("0001/0110/1100/0001", "three-beat grounded run"),  # one or two
        ("0011/1100/0110/1001", "four-beat walk"),  # two, so a half
        ("0011/1110/1110/1001", "three-beat walk"),  # two or three
        ("0111/0011/0001/1100", "four-beat walk"),  # one to three, two in the mean
    ],
)
def test_legs_that_stand_for_less_than_half_of_the_cycle_run_without_flight(text: str, kind: str) -> None:
    assert gait_kind(Pattern.from_text(text), LEGS) == kind


def test_the_order_of_landing_tells_canter_and_gallop_from_runs() -> None:
    backwards = {kind: Pattern(tuple(row[::-1] for row in KINDS[kind].split("/"))) for kind in ("canter", "gallop")}
    assert gait_kind(backwards["canter"], LEGS) == "three-beat run"
    assert gait_kind(backwards["gallop"], LEGS) == "gallop", "hind, hind, front, front read backwards is couplets too"
    lateral = Pattern.from_text("011000/000110/110000/001100")  # LH, LF, RH, RF
    assert gait_kind(lateral, LEGS) == "four-beat run"
    half_bound = Pattern.from_text("01100/00110/11000/11000")
    assert gait_kind(half_bound, LEGS) == "gallop"


def test_names_are_one_to_one_over_all_single_stance_gaits() -> None:
    gaits = single_stance_gaits()
    names = {gait_name(gait, LEGS) for gait in gaits}
    assert len(names) == len(gaits) > 1_000
    assert set(ARCHETYPES) <= names
    kinds = {gait_kind(gait, LEGS) for gait in gaits}
    assert {name.rsplit(" ", 1)[0] if "/" in name else name for name in names} == kinds
    walks = {f"{count}-beat {kind}" for count in ("two", "three", "four") for kind in ("walk", "grounded run")}
    runs = {f"{count}-beat run" for count in ("one", "two", "three")}
    assert kinds == set(ARCHETYPES) | walks | runs | {"gallop", "canter"}


def test_walks_never_fly_and_runs_do() -> None:
    grounded = ("walk", "walking trot", "walking pace", "walking bound", "trot", "pace")
    for gait in single_stance_gaits():
        kind = gait_kind(gait, LEGS)
        flies = any(not any(gait.column(phase)) for phase in range(gait.phases))
        assert flies != (kind.endswith(("walk", "grounded run")) or kind in grounded), (gait.text, kind)


@given(quadruped_patterns, st.integers(-10, 10), st.data())
def test_names_know_neither_cut_nor_split_phases_nor_left_and_right(
    pattern: Pattern, cut: int, data: st.DataObject
) -> None:
    phase = data.draw(st.integers(0, pattern.phases - 1))
    same = (pattern.rotated(cut), split(pattern, phase), pattern.mirrored(MIRROR), gait_of(pattern, LEFT_RIGHT))
    for image in same:
        assert gait_name(image, LEGS) == gait_name(pattern, LEGS)
        assert gait_kind(image, LEGS) == gait_kind(pattern, LEGS)


@given(quadruped_patterns, quadruped_patterns)
def test_different_gaits_have_different_names(one: Pattern, other: Pattern) -> None:
    same = gait_of(one, LEFT_RIGHT) == gait_of(other, LEFT_RIGHT)
    assert (gait_name(one, LEGS) == gait_name(other, LEGS)) == same


@pytest.mark.parametrize(
    "leg_names",
    [("FL", "FR", "RL", "RR"), ("FL", "FR", "HL", "HR"), ("LF", "RF", "LR", "RR"), ("FR", "FL", "RR", "RL")],
)
def test_robots_spell_their_legs_in_several_ways(leg_names: tuple[str, ...]) -> None:
    for gait in single_stance_gaits()[::7]:
        kind = gait_kind(gait, LEGS)
        assert gait_kind(gait, leg_names) == kind


@pytest.mark.parametrize("order", list(permutations(range(4)))[::3])
def test_the_order_of_the_legs_changes_no_kind_and_no_plain_name(order: tuple[int, ...]) -> None:
    leg_names = [LEGS[leg] for leg in order]
    for text in ARCHETYPES.values():
        pattern = Pattern.from_text(text)
        reordered = Pattern(tuple(pattern.rows[leg] for leg in order))
        assert gait_name(reordered, leg_names) == gait_name(pattern, LEGS)
    mirror = Symmetry(mirror=tuple(order.index(MIRROR[leg]) for leg in order))
    for text in KINDS.values():
        reordered = Pattern(tuple(Pattern.from_text(text).rows[leg] for leg in order))
        assert gait_name(reordered, leg_names) == f"{gait_kind(reordered, leg_names)} {gait_of(reordered, mirror).text}"


@pytest.mark.parametrize(
    ("names", "place"),
    [
        (("LF", "FL"), (1, 1)),
        (("RF", "FR"), (1, -1)),
        (("LH", "HL", "LR", "RL"), (-1, 1)),
        (("RH", "HR", "RR"), (-1, -1)),
        (("F", "H", "L", "LM", "LL", "FF", "HH", "FH", "LFX", "A", ""), None),
    ],
)
def test_the_place_that_a_name_tells(names: tuple[str, ...], place: tuple[int, int] | None) -> None:
    assert {leg_place(name) for name in names} == {place}


def test_a_quadruped_has_a_leg_in_each_corner() -> None:
    assert quadruped_places(("FR", "FL", "RR", "RL")) == (1, 0, 3, 2)
    assert quadruped_places(("FL", "RF", "HL", "RR")) == (0, 1, 2, 3), "spellings may be mixed"
    assert quadruped_places(("FL", "LF", "HL", "RR")) is None
    assert quadruped_places(("LF", "RF", "LH", "RH", "T")) is None


@pytest.mark.parametrize("leg_names", [("A", "B", "C", "D"), ("FL", "LF", "HL", "RR"), ("LF", "RF", "LM", "RM")])
def test_four_legs_that_are_no_quadruped_have_diagrams(leg_names: tuple[str, ...]) -> None:
    trot = Pattern.from_text("01/10/10/01")
    drawn = " / ".join(f"{name} {row}" for name, row in zip(leg_names, trot.rows, strict=True))
    assert gait_name(trot, leg_names) == gait_kind(trot, leg_names) == drawn


def test_other_legs_have_diagrams() -> None:
    assert gait_name(Pattern.from_text("0111/1101"), ("L", "R")) == "L 0111 / R 1101"
    hexapod = Pattern.from_text("01/10/01/10/01/10")
    assert gait_name(hexapod, tuple("ABCDEF")).startswith("A 01 / B 10 /")


@pytest.mark.parametrize("asked", [gait_name, gait_kind])
def test_a_name_for_each_leg_is_needed(asked) -> None:
    with pytest.raises(ValueError, match="2 legs, but the names are LF, RF, LH, RH"):
        asked(Pattern.from_text("01/10"), LEGS)
