from __future__ import annotations

from matplotlib.colors import to_rgb

from gaitflow.gait_names import gait_name
from gaitflow.gaits import Pattern
from gaitflow.report.palette import NAMED_COLOURS, OTHER_COLOURS, gait_colours, lighter, ordered_gaits

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
