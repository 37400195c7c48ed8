from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PathCollection, QuadMesh
from matplotlib.colors import to_rgba

from gaitflow.config.axes import Tasks
from gaitflow.report.gait_map import MAX_NAMED, TAIL, draw_gait_map
from gaitflow.report.palette import NAMED_COLOURS, lighter


def axes_of(figure):
    (axes,) = figure.axes
    return axes


def legend_texts(figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_region_under_a_task_has_the_colour_of_the_gait_chosen_there(labels, gaits, select, tasks) -> None:
    figure = draw_gait_map(labels, gaits, select, "a map", tasks)
    axes = axes_of(figure)
    figure.canvas.draw()
    (mesh,) = [item for item in axes.collections if isinstance(item, QuadMesh)]
    array = np.asarray(mesh.get_array())
    for task, place in (((0.1, 0.4), (0, 0)), ((2.3, 1.6), (-1, -1)), ((2.3, 0.4), (0, -1))):
        expected = gaits[int(select({"speed": np.array([task[0]]), "cycle_duration": np.array([task[1]])})[0])]
        shown = mesh.cmap(mesh.norm(array[place]))
        assert shown == pytest.approx(to_rgba(lighter(NAMED_COLOURS[expected], 0.5)))


def test_tasks_are_drawn_where_and_as_what_they_are(labels, gaits, select, tasks) -> None:
    axes = axes_of(draw_gait_map(labels, gaits, select, "a map", tasks))
    grid, held_out, ties, infeasible = [item for item in axes.collections if isinstance(item, PathCollection)]
    assert [len(item.get_offsets()) for item in (grid, held_out, ties, infeasible)] == [83, 25, 6, 1]
    np.testing.assert_allclose(infeasible.get_offsets(), [[0.1, 1.6]])
    solved = labels[(labels["status"] == "solved") & (labels["split"] == "grid")]
    for place, colour in zip(solved["gait"], grid.get_facecolors(), strict=True):
        assert tuple(colour) == pytest.approx(to_rgba(NAMED_COLOURS[place]))


def test_axes_have_units_and_the_legend_says_what_is_there(labels, gaits, select, tasks) -> None:
    figure = draw_gait_map(labels, gaits, select, "a map", tasks)
    axes = axes_of(figure)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("speed v [m/s]", "cycle duration T [s]")
    texts = legend_texts(figure)
    won = labels[labels["status"] == "solved"]["gait"].value_counts()
    counts = [won.get(name, 0) for name in texts[: len(gaits)]]
    assert set(texts[: len(gaits)]) == set(gaits) and counts == sorted(counts, reverse=True)
    assert texts[-4:] == ["grid task", "held-out task", "gaits tie", "no gait found"]


def test_the_legend_of_long_diagrams_is_below_the_map(map_of, tasks) -> None:
    name = "LF 0110 / RF 1100 / LH 1001 / RH 0011"
    figure = draw_gait_map(map_of(lambda v, t: "gallop").assign(gait=name), [name], None, "a map", tasks)
    figure.canvas.draw()
    assert figure.legends[0].get_window_extent().y1 < axes_of(figure).get_window_extent().y0


def test_many_gaits_of_a_quadruped_are_numbered_and_the_smallest_regions_share_a_colour(map_of, tasks) -> None:
    gaits = [f"four-beat walk {i:04b}/1101/1011/1110" for i in range(16)]
    places = np.linspace(0.1, 2.3, 136)
    wins = np.repeat(np.arange(16), np.arange(16) + 1)  # the first gait has the smallest region
    gait_at = {round(v, 9): gaits[i] for v, i in zip(places, wins, strict=True)}
    labels = map_of(lambda v, t: "gallop", speeds=np.array(list(gait_at)), durations=np.array([0.4, 0.8]))
    labels["gait"] = [gait_at[round(v, 9)] for v in labels["speed"]]
    index_at = np.array([gaits.index(name) for name in gait_at.values()])

    def select(values):
        return index_at[np.abs(places[:, None] - values["speed"]).argmin(axis=0)]

    figure = draw_gait_map(labels, gaits, select, "a map", tasks)
    texts = legend_texts(figure)
    assert texts[: MAX_NAMED + 1] == [*(f"{i}   {gaits[16 - i]}" for i in range(1, 13)), "4 other gaits"]
    axes = axes_of(figure)
    assert {text.get_text() for text in axes.texts} <= {str(i) for i in range(1, 13)}
    assert len(axes.texts) > 3
    (grid, *_) = [item for item in axes.collections if isinstance(item, PathCollection)]
    tail = [place for place, name in zip(grid.get_facecolors(), labels["gait"], strict=True) if name in gaits[:4]]
    assert len(tail) == 2 * (1 + 2 + 3 + 4)
    assert {tuple(colour) for colour in tail} == {to_rgba(TAIL)}


def test_the_legend_leaves_out_what_is_not_there(map_of, rule_4a, tasks) -> None:
    figure = draw_gait_map(map_of(rule_4a, speeds=np.array([0.5, 0.7])), ["gallop-walk"], None, "a map", tasks)
    assert legend_texts(figure) == ["gallop-walk", "grid task"]


def test_without_a_classifier_there_are_no_regions(labels, gaits, tasks) -> None:
    axes = axes_of(draw_gait_map(labels, gaits, None, "a map", tasks))
    assert not [item for item in axes.collections if isinstance(item, QuadMesh)]


def test_outside_the_domain_nothing_is_filled(labels, gaits, tasks) -> None:
    def select(values):
        return np.where(values["speed"] > 1.0, -1, gaits.index("gallop"))

    axes = axes_of(draw_gait_map(labels, gaits, select, "a map", tasks))
    (mesh,) = [item for item in axes.collections if isinstance(item, QuadMesh)]
    masked = np.ma.getmaskarray(mesh.get_array())
    assert masked[:, -1].all()
    assert not masked[:, 0].any()


def test_a_map_of_one_gait_and_of_one_infeasible_task_can_be_drawn(map_of, infeasible, tasks) -> None:
    draw_gait_map(
        map_of(lambda v, t: "gallop"), ["gallop"], lambda values: np.zeros(len(values["speed"]), int), "one gait", tasks
    )
    draw_gait_map(pd.DataFrame([infeasible(0.1, 0.4)]), [], None, "nothing feasible", tasks)


def test_an_index_that_is_no_gait_is_refused(labels, tasks) -> None:
    with pytest.raises(ValueError, match="select answered 7 to 7, but the gaits are numbered 0 to 0"):
        draw_gait_map(labels, ["gallop"], lambda values: np.full(len(values["speed"]), 7), "a map", tasks)


def test_labels_without_tasks_are_refused(labels, tasks) -> None:
    with pytest.raises(ValueError, match="no task"):
        draw_gait_map(labels.iloc[:0], [], None, "a map", tasks)


def test_a_map_over_slopes_is_a_panel_a_slope(sloped, sloped_labels, gaits, rule_4a) -> None:
    asked = []

    def select(values):
        asked.append(set(np.unique(values["slope"])))
        places = zip(values["speed"] * (1 + np.abs(values["slope"]) / 44), values["cycle_duration"], strict=True)
        return np.array([gaits.index(rule_4a(v, t)) for v, t in places])

    figure = draw_gait_map(sloped_labels, gaits, select, "over slopes", sloped.tasks)
    shown = [axes for axes in figure.axes if axes.get_visible() and axes.axison]
    assert [axes.get_title(loc="left") for axes in shown][:2] == ["slope = -22°", "slope = -18°"]
    assert asked[0] == {-22.0} and len(shown) == len({slope for slopes in asked for slope in slopes}) == 9
    assert [axes.get_xlabel() for axes in shown[-3:]] == ["speed v [m/s]"] * 3
    assert shown[3].get_ylabel() == "cycle duration T [s]" and shown[4].get_ylabel() == ""
    for axes in shown:
        (grid, *_) = [item for item in axes.collections if isinstance(item, PathCollection)]
        assert len(grid.get_offsets()) == 84


def test_a_map_of_one_axis_is_a_strip(map_of, rule_4a, gaits) -> None:
    labels = map_of(rule_4a, durations=np.array([0.8]))
    tasks = Tasks.from_data(
        {"axes": {"speed": {"start": 0.1, "stop": 2.3, "count": 12}, "cycle_duration": 0.8}}, "tasks"
    )

    def select(values):
        assert set(values) == {"speed"}
        return np.array([gaits.index(rule_4a(v, 0.8)) for v in values["speed"]])

    axes = axes_of(draw_gait_map(labels, gaits, select, "one axis", tasks))
    assert axes.get_xlabel() == "speed v [m/s]" and list(axes.get_yticks()) == []
    (grid, *_) = [item for item in axes.collections if isinstance(item, PathCollection)]
    np.testing.assert_allclose(grid.get_offsets(), [(v, 0.0) for v in labels["speed"]])


def test_tasks_off_the_grid_are_circles_within_the_ranges_of_the_scenario(labels, gaits, select, tasks) -> None:
    inside = labels[(labels["speed"] > 0.5) & (labels["speed"] < 1.5) & (labels["status"] == "solved")]
    chosen = inside.assign(split=inside["split"].replace("grid", "sampled"))
    figure = draw_gait_map(chosen, gaits, select, "chosen tasks", tasks)
    axes = axes_of(figure)
    circles, diamonds, *_ = [item for item in axes.collections if isinstance(item, PathCollection)]
    assert len(circles.get_offsets()) == (chosen["split"] == "sampled").sum()
    assert len(diamonds.get_offsets()) == (chosen["split"] == "held_out").sum()
    (mesh,) = [item for item in axes.collections if isinstance(item, QuadMesh)]
    assert mesh.get_coordinates()[..., 0].max() == pytest.approx(2.3, abs=0.01)
    assert mesh.get_coordinates()[..., 0].min() == pytest.approx(0.1, abs=0.01)
    assert legend_texts(figure)[-2:] == ["searched task", "held-out task"]


def test_two_further_axes_are_a_matrix_of_panels(turning, turning_labels, gaits, turning_select) -> None:
    asked = []

    def select(values):
        asked.append((values["lateral_speed"][0], values["yaw_rate"][0]))
        return turning_select(values)

    figure = draw_gait_map(turning_labels, gaits, select, "four axes", turning.tasks)
    assert list(dict.fromkeys(asked)) == [(lateral, yaw) for lateral in (-0.4, 0.0, 0.4) for yaw in (-0.6, 0.2, 0.6)]
    tops = [axes.get_title(loc="left") for axes in figure.axes]
    assert tops == ["yaw rate = -0.6 rad/s", "yaw rate = 0.2 rad/s", "yaw rate = 0.6 rad/s", *[""] * 6]
    rows = [[text.get_text() for text in axes.texts if "=" in text.get_text()] for axes in figure.axes]
    assert rows == [
        [],
        [],
        ["lateral speed = -0.4 m/s"],
        [],
        [],
        ["lateral speed = 0 m/s"],
        [],
        [],
        ["lateral speed = 0.4 m/s"],
    ]
    figure.canvas.draw()
    heading = next(text for text in figure.axes[5].texts if "=" in text.get_text()).get_window_extent()
    assert heading.x1 <= figure.bbox.x1 and heading.x0 >= figure.axes[5].get_window_extent().x1


def test_a_slice_without_a_task_has_its_regions(turning, turning_labels, gaits, turning_select) -> None:
    left = turning_labels[turning_labels["yaw_rate"] > 0.4]
    figure = draw_gait_map(left, gaits, turning_select, "half of it", turning.tasks)
    tasks, meshes = (
        [[item for item in axes.collections if isinstance(item, kind)] for axes in figure.axes]
        for kind in (PathCollection, QuadMesh)
    )
    assert [sum(len(item.get_offsets()) for item in panel) > 0 for panel in tasks] == [False, False, True] * 3
    assert all(len(panel) == 1 for panel in meshes)
    named = [{text.get_text() for text in axes.texts} & set(gaits) for axes in figure.axes]
    assert all(named)
