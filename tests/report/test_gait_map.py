from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.colors import to_rgba

from gaitflow.core.task_space import TaskSpace
from gaitflow.report.gait_map import MAX_NAMED, RESOLUTION, TAIL, draw_gait_map
from gaitflow.report.palette import NAMED_COLOURS, lighter


def axes_of(figure):
    (axes,) = figure.axes
    return axes


def legend_texts(figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_region_under_a_task_has_the_colour_of_the_gait_chosen_there(labels, gaits, select, space) -> None:
    figure = draw_gait_map(labels, gaits, select, "a map", space)
    axes = axes_of(figure)
    figure.canvas.draw()
    (mesh,) = [item for item in axes.collections if isinstance(item, QuadMesh)]
    array = np.asarray(mesh.get_array())
    for task, place in (((0.1, 0.4), (0, 0)), ((2.3, 1.6), (-1, -1)), ((2.3, 0.4), (0, -1))):
        expected = gaits[int(select({"speed": np.array([task[0]]), "cycle_duration": np.array([task[1]])})[0])]
        shown = mesh.cmap(mesh.norm(array[place]))
        assert shown == pytest.approx(to_rgba(lighter(NAMED_COLOURS[expected], 0.5)))


def test_tasks_are_drawn_where_and_as_what_they_are(labels, gaits, select, space) -> None:
    axes = axes_of(draw_gait_map(labels, gaits, select, "a map", space))
    grid, held_out, ties, infeasible = [item for item in axes.collections if isinstance(item, PathCollection)]
    assert [len(item.get_offsets()) for item in (grid, held_out, ties, infeasible)] == [83, 25, 6, 1]
    np.testing.assert_allclose(infeasible.get_offsets(), [[0.1, 1.6]])
    solved = labels[(labels["status"] == "solved") & (labels["split"] == "grid")]
    for place, colour in zip(solved["gait"], grid.get_facecolors(), strict=True):
        assert tuple(colour) == pytest.approx(to_rgba(NAMED_COLOURS[place]))


def test_axes_have_units_and_the_legend_says_what_is_there(labels, gaits, select, space) -> None:
    figure = draw_gait_map(labels, gaits, select, "a map", space)
    axes = axes_of(figure)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed v [m/s]", "cycle duration T [s]")
    texts = legend_texts(figure)
    won = labels[labels["status"] == "solved"]["gait"].value_counts()
    counts = [won.get(name, 0) for name in texts[: len(gaits)]]
    assert set(texts[: len(gaits)]) == set(gaits) and counts == sorted(counts, reverse=True)
    assert texts[-4:] == ["grid task", "held-out task", "gaits tie", "no gait found"]


def test_the_legend_of_long_diagrams_is_below_the_map(map_of, space) -> None:
    name = "LF 0110 / RF 1100 / LH 1001 / RH 0011"
    figure = draw_gait_map(map_of(lambda v, t: "gallop").assign(gait=name), [name], None, "a map", space)
    figure.canvas.draw()
    assert figure.legends[0].get_window_extent().y1 < axes_of(figure).get_window_extent().y0


def test_many_gaits_of_a_quadruped_are_numbered_and_the_smallest_regions_share_a_colour(map_of, space) -> None:
    gaits = [f"four-beat walk {i:04b}/1101/1011/1110" for i in range(16)]
    places = np.linspace(0.1, 2.3, 136)
    wins = np.repeat(np.arange(16), np.arange(16) + 1)  # the first gait has the smallest region
    gait_at = {round(v, 9): gaits[i] for v, i in zip(places, wins, strict=True)}
    labels = map_of(lambda v, t: "gallop", speeds=np.array(list(gait_at)), durations=np.array([0.4, 0.8]))
    labels["gait"] = [gait_at[round(v, 9)] for v in labels["speed"]]

    def select(values):
        row = [gaits.index(gait_at[min(gait_at, key=lambda x: abs(x - v))]) for v in values["speed"][:RESOLUTION]]
        return np.array(row * RESOLUTION)

    figure = draw_gait_map(labels, gaits, select, "a map", space)
    texts = legend_texts(figure)
    assert texts[: MAX_NAMED + 1] == [*(f"{i}   {gaits[16 - i]}" for i in range(1, 13)), "4 other gaits"]
    axes = axes_of(figure)
    assert {text.get_text() for text in axes.texts} <= {str(i) for i in range(1, 13)}
    assert len(axes.texts) > 3
    (grid, *_) = [item for item in axes.collections if isinstance(item, PathCollection)]
    tail = [place for place, name in zip(grid.get_facecolors(), labels["gait"], strict=True) if name in gaits[:4]]
    assert len(tail) == 2 * (1 + 2 + 3 + 4)
    assert {tuple(colour) for colour in tail} == {to_rgba(TAIL)}


def test_the_legend_leaves_out_what_is_not_there(map_of, rule_4a, space) -> None:
    figure = draw_gait_map(map_of(rule_4a, speeds=np.array([0.5, 0.7])), ["gallop-walk"], None, "a map", space)
    assert legend_texts(figure) == ["gallop-walk", "grid task"]


def test_without_a_classifier_there_are_no_regions(labels, gaits, space) -> None:
    axes = axes_of(draw_gait_map(labels, gaits, None, "a map", space))
    assert not [item for item in axes.collections if isinstance(item, QuadMesh)]


def test_outside_the_domain_nothing_is_filled(labels, gaits, space) -> None:
    def select(values):
        return np.where(values["speed"] > 1.0, -1, gaits.index("gallop"))

    axes = axes_of(draw_gait_map(labels, gaits, select, "a map", space))
    (mesh,) = [item for item in axes.collections if isinstance(item, QuadMesh)]
    masked = np.ma.getmaskarray(mesh.get_array())
    assert masked[:, -1].all()
    assert not masked[:, 0].any()


def test_a_map_of_one_gait_and_of_one_infeasible_task_can_be_drawn(map_of, infeasible, space) -> None:
    draw_gait_map(
        map_of(lambda v, t: "gallop"), ["gallop"], lambda values: np.zeros(len(values["speed"]), int), "one gait", space
    )
    draw_gait_map(pd.DataFrame([infeasible(0.1, 0.4)]), [], None, "nothing feasible", space)


def test_an_index_that_is_no_gait_is_refused(labels, space) -> None:
    with pytest.raises(ValueError, match="select answered 7 to 7, but the gaits are numbered 0 to 0"):
        draw_gait_map(labels, ["gallop"], lambda values: np.full(len(values["speed"]), 7), "a map", space)


def test_labels_without_tasks_are_refused(labels, space) -> None:
    with pytest.raises(ValueError, match="no task"):
        draw_gait_map(labels.iloc[:0], [], None, "a map", space)


def test_a_map_over_slopes_is_a_panel_a_slope(sloped, sloped_labels, gaits, rule_4a) -> None:
    asked = []

    def select(values):
        asked.append(set(np.unique(values["slope"])))
        tasks = zip(values["speed"] * (1 + np.abs(values["slope"]) / 44), values["cycle_duration"], strict=True)
        return np.array([gaits.index(rule_4a(v, t)) for v, t in tasks])

    figure = draw_gait_map(sloped_labels, gaits, select, "over slopes", sloped.tasks.space)
    shown = [axes for axes in figure.axes if axes.get_visible() and axes.axison]
    assert [axes.get_title(loc="left") for axes in shown][:2] == ["slope = -22°", "slope = -18°"]
    assert asked[0] == {-22.0} and len(asked) == len(shown) == 9
    assert [axes.get_xlabel() for axes in shown[-3:]] == ["speed v [m/s]"] * 3
    assert shown[3].get_ylabel() == "cycle duration T [s]" and shown[4].get_ylabel() == ""
    for axes in shown:
        (grid, *_) = [item for item in axes.collections if isinstance(item, PathCollection)]
        assert len(grid.get_offsets()) == 84


def test_a_map_of_one_axis_is_a_strip(map_of, rule_4a, gaits) -> None:
    labels = map_of(rule_4a, durations=np.array([0.8]))
    space = TaskSpace(("speed",), (("cycle_duration", 0.8),))

    def select(values):
        assert set(values) == {"speed"}
        return np.array([gaits.index(rule_4a(v, 0.8)) for v in values["speed"]])

    axes = axes_of(draw_gait_map(labels, gaits, select, "one axis", space))
    assert axes.get_xlabel() == "speed v [m/s]" and list(axes.get_yticks()) == []
    (grid, *_) = [item for item in axes.collections if isinstance(item, PathCollection)]
    np.testing.assert_allclose(grid.get_offsets(), [(v, 0.0) for v in labels["speed"]])
