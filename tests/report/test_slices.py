"""A map of any number of axes as panels of two."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from gaitflow.config.axes import Tasks
from gaitflow.core.task_space import TaskSpace
from gaitflow.report.slices import main_axes, slices_of


@pytest.mark.parametrize(
    ("axes", "main"),
    [
        (("speed", "cycle_duration"), ("speed", "cycle_duration")),
        (("speed", "lateral_speed", "cycle_duration", "slope"), ("speed", "cycle_duration")),
        (("cycle_duration", "slope", "friction"), ("cycle_duration", "slope")),
        (("speed", "slope"), ("speed", "slope")),
        (("slope",), ("slope", None)),
    ],
)
def test_speed_and_cycle_duration_are_the_main_axes_where_they_vary(axes, main) -> None:
    assert main_axes(TaskSpace(axes, ())) == main


def test_a_map_of_two_axes_is_one_panel_with_all_tasks(labels, tasks) -> None:
    slices = slices_of(labels, tasks)
    (panel,) = slices.panels
    assert (slices.x, slices.y, panel.at, len(panel.labels)) == ("speed", "cycle_duration", {}, len(labels))
    assert slices.limits == {"speed": (0.1, 2.3), "cycle_duration": (0.4, 1.6)} and slices.remark == ""


def test_of_many_slices_nine_are_drawn_from_the_first_to_the_last(sloped, sloped_labels) -> None:
    slices = slices_of(sloped_labels, sloped.tasks)
    slopes = [panel.at["slope"] for panel in slices.panels]
    assert len(slopes) == 9 and slopes == sorted(set(slopes)) and (slopes[0], slopes[-1]) == (-22.0, 22.0)
    assert all(len(panel.labels) == 84 and set(panel.labels["slope"]) == {panel.at["slope"]} for panel in slices.panels)
    assert "9 of 12 slices" in slices.remark and "1 held-out tasks lie between" in slices.remark


def over(**counts: int) -> Tasks:
    """Axes with so many values from 0.1 to 0.5."""
    axes = {axis: {"start": 0.1, "stop": 0.5, "count": count} for axis, count in counts.items()}
    return Tasks.from_data({"axes": axes}, "tasks")


@pytest.mark.parametrize(
    ("further", "drawn"),
    [
        ({"slope": 5, "friction": 5}, [3, 3]),
        ({"slope": 2, "friction": 7}, [2, 4]),
        ({"slope": 5, "friction": 3, "payload": 3}, [2, 2, 2]),
        ({"lateral_speed": 5, "slope": 5, "friction": 3, "payload": 3}, [2, 2, 2, 1]),
    ],
)
def test_panels_are_shared_evenly_among_further_axes(labels, further, drawn) -> None:
    row = labels.iloc[:1].assign(**dict.fromkeys(further, 0.1))
    slices = slices_of(row, over(speed=3, cycle_duration=3, **further))
    assert [len(values) for values in slices.further.values()] == drawn
    assert len(slices.panels) == np.prod(drawn) and slices.count == np.prod(list(further.values()))
    kept = [list(values) for values in slices.further.values() if len(values) > 1]
    assert all((values[0], values[-1]) == (0.1, 0.5) for values in kept)
    assert [tuple(panel.at.values()) for panel in slices.panels] == list(product(*slices.further.values()))


def test_tasks_off_the_grid_are_drawn_in_the_nearest_slice(turning, turning_labels) -> None:
    slices = slices_of(turning_labels, turning.tasks, most=20)
    assert len(slices.panels) == slices.count == 20 and slices.between == 0
    assert slices.remark == "Each task is drawn in the slice nearest to it."
    assert sum(len(panel.labels) for panel in slices.panels) == len(turning_labels) == 360
    for panel in slices.panels:
        assert (panel.labels["lateral_speed"] - panel.at["lateral_speed"]).abs().max() <= 0.1
        assert (panel.labels["yaw_rate"] - panel.at["yaw_rate"]).abs().max() <= 0.2


def test_of_a_drawn_part_of_the_slices_no_task_is_drawn_further_than_half_a_step_away(turning, turning_labels) -> None:
    slices = slices_of(turning_labels, turning.tasks)
    assert slices.further == {"lateral_speed": (-0.4, 0.0, 0.4), "yaw_rate": (-0.6, 0.2, 0.6)}
    assert slices.remark.startswith("9 of 20 slices")
    assert sum(len(panel.labels) for panel in slices.panels) < 360
    for panel in slices.panels:
        assert (panel.labels["lateral_speed"] - panel.at["lateral_speed"]).abs().max() <= 0.1


def test_held_out_tasks_alone_are_drawn_in_the_nearest_slice(sloped_labels, sloped) -> None:
    slices = slices_of(sloped_labels[sloped_labels["split"] == "held_out"], sloped.tasks, most=12)
    (panel,) = [panel for panel in slices.panels if len(panel.labels)]
    assert panel.at == {"slope": 2.0} and np.array_equal(panel.labels["slope"], [1.7])
