from __future__ import annotations

from matplotlib.colors import to_rgb

from gaitflow.core.gaits import Pattern, Symmetry, all_patterns, gait_of
from gaitflow.core.names import gait_kind, gait_name
from gaitflow.report.palette import (
    KIND_COLOURS,
    NAMED_COLOURS,
    OTHER_COLOURS,
    gait_colours,
    kind_and_contacts,
    lighter,
    ordered_gaits,
)

LEGS, MIRROR = ("LF", "RF", "LH", "RH"), Symmetry(mirror=(1, 0, 3, 2))

FIG5 = ("0111/1101", "0110/1100", "0001/0100", "0110/0100", "011/110", "010/110", "010/100")


def test_the_names_of_figure_5_have_fixed_colours() -> None:
    assert {gait_name(Pattern.from_text(text), ("F", "H")) for text in FIG5} == set(NAMED_COLOURS)


def test_a_named_gait_has_one_colour_whatever_else_is_in_the_figure() -> None:
    alone = gait_colours(["gallop"])
    among = gait_colours(["F 01 / H 01", "gallop", "bounding", "A strange one"])
    assert among["gallop"] == alone["gallop"] == NAMED_COLOURS["gallop"]


def test_named_gaits_come_first_then_the_others_sorted_once_each() -> None:
    assert ordered_gaits(["z", "gallop", "a", "walking", "gallop"]) == ("walking", "gallop", "a", "z")


def test_many_gaits_without_a_name_all_differ() -> None:
    names = [f"gait {i:02d}" for i in range(3 * len(OTHER_COLOURS))]
    colours = gait_colours(names)
    assert len(set(colours.values())) == len(names)
    assert not set(colours.values()) & set(NAMED_COLOURS.values())


def test_lighter_moves_towards_white() -> None:
    assert lighter("#000000", 1.0) == "#ffffff"
    assert lighter("#123456", 0.0) == "#123456"
    assert all(a < b for a, b in zip(to_rgb("#123456"), to_rgb(lighter("#123456", 0.5)), strict=True))


def test_every_kind_of_a_quadrupeds_single_stance_gaits_has_a_colour() -> None:
    gaits = {gait_of(pattern, MIRROR) for pattern in all_patterns(4, 4, stances_per_leg=1, symmetry=MIRROR)}
    assert {gait_kind(gait, LEGS) for gait in gaits} <= KIND_COLOURS.keys() | NAMED_COLOURS.keys()
    assert len({colour.lower() for colour in KIND_COLOURS.values()}) == len(KIND_COLOURS)


def test_gaits_of_a_kind_have_shades_of_its_colour_and_stand_together() -> None:
    names = [f"four-beat walk {gait}" for gait in ("0111/1101/1110/1011", "0111/1110/1101/1011", "0011/1001/1100/1110")]
    found = gait_colours([*names, "four-beat walk", "walking trot", "gallop"])
    assert found["four-beat walk"] == KIND_COLOURS["four-beat walk"]
    assert len(set(found.values())) == 6
    assert list(found) == ["four-beat walk", *sorted(names), "walking trot", "gallop"]
    blue = [to_rgb(found[name]) for name in names]
    assert all(red < green < channel for red, green, channel in blue)


def test_a_name_is_taken_apart_only_where_it_ends_with_contacts() -> None:
    assert kind_and_contacts("four-beat walk 0111/1101/1110/1011") == ("four-beat walk", "0111/1101/1110/1011")
    assert kind_and_contacts("walking trot") == ("walking trot", "")
    assert kind_and_contacts("F 0011 / H 1001") == ("F 0011 / H 1001", "")
