from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from gaitflow.report.gait_diagrams import draw_contacts, draw_gait_diagrams
from gaitflow.report.palette import NAMED_COLOURS, gait_colours


def stances(axes, colour: str) -> set[tuple[float, float, float]]:
    """(leg, start, end) of the solid bars."""
    bars = [bar for bar in axes.patches if bar.get_facecolor() == pytest.approx(to_rgba(colour))]
    middle = [bar.get_y() + bar.get_height() / 2 for bar in bars]
    return {(round(y), bar.get_x(), bar.get_x() + bar.get_width()) for y, bar in zip(middle, bars, strict=True)}


def test_bars_stand_where_the_legs_do() -> None:
    axes = Figure().add_subplot()
    draw_contacts(axes, "0110/1000", np.array([1.0, 2.0, 3.0, 4.0]), ["F", "H"], "#ff0000")
    assert stances(axes, "#ff0000") == {(0, 1.0, 3.0), (0, 3.0, 6.0), (1, 0.0, 1.0)}
    assert axes.get_xlim() == (0, 10)
    assert [label.get_text() for label in axes.get_yticklabels()] == ["F", "H"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first leg is on top


def test_phases_have_their_mean_durations_not_equal_widths(solution_of) -> None:
    region = [solution_of(1.5, 0.8, "gallop"), solution_of(1.1, 1.2, "gallop")]
    figure = draw_gait_diagrams({"gallop": region}, ["F", "H"], NAMED_COLOURS)
    (axes,) = figure.axes
    mean = np.mean([solution.trajectory.durations / solution.task.cycle_duration for solution in region], axis=0)
    starts = sorted(start for leg, start, _ in stances(axes, NAMED_COLOURS["gallop"]) if leg == 0)
    np.testing.assert_allclose(starts, 100 * np.cumsum(mean)[:2])
    assert abs(mean - 0.25).max() > 0.02


def test_every_gait_has_its_name_and_number_of_tasks(solution_of) -> None:
    regions = {name: [solution_of(0.5, 0.8, name)] for name in ("walking", "gallop", "bounding", "pronking")}
    figure = draw_gait_diagrams({**regions, "gallop-bound": []}, ["F", "H"], NAMED_COLOURS)
    assert [axes.get_title(loc="left") for axes in figure.axes] == list(regions)
    assert {axes.get_title(loc="right") for axes in figure.axes} == {"1 task"}


def test_no_trajectory_at_all_is_refused() -> None:
    with pytest.raises(ValueError, match="no gait has a stored trajectory"):
        draw_gait_diagrams({"gallop": []}, ["F", "H"], NAMED_COLOURS)


def test_a_quadrupeds_gait_has_four_bars_and_its_contacts_below_its_kind(trot) -> None:
    other = "four-beat walk 0111/1011/1110/1101"
    figure = draw_gait_diagrams(
        {"walking trot": [trot], other: [trot]},
        ["LF", "RF", "LH", "RH"],
        gait_colours([other]) | {"walking trot": "#117733"},
    )
    trots, walks = figure.axes
    assert [axes.get_title(loc="left").strip() for axes in figure.axes] == ["walking trot", "four-beat walk"]
    assert [text.get_text() for text in walks.texts] == ["0111/1011/1110/1101"]
    assert not trots.texts
    assert {leg for leg, _, _ in stances(trots, "#117733")} == {0, 1, 2, 3}
    assert [label.get_text() for label in trots.get_yticklabels()] == ["LF", "RF", "LH", "RH"]
