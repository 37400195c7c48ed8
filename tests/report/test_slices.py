"""A map of any number of axes as panels of two."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from gaitflow.core.task_space import TaskSpace
from gaitflow.report.slices import main_axes, slices_of


def over(*axes: str) -> TaskSpace:
    return TaskSpace(axes, ())


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
    assert main_axes(over(*axes)) == main


def test_a_map_of_two_axes_is_one_panel_with_all_tasks(labels, space) -> None:
    slices = slices_of(labels, space)
    (panel,) = slices.panels
    assert (slices.x, slices.y, panel.at, len(panel.labels)) == ("speed", "cycle_duration", {}, len(labels))
    assert slices.remark == ""


def test_of_many_slices_nine_are_drawn_from_the_first_to_the_last(sloped, sloped_labels) -> None:
    slices = slices_of(sloped_labels, sloped.tasks.space)
    slopes = [panel.at["slope"] for panel in slices.panels]
    assert len(slopes) == 9 and slopes == sorted(set(slopes)) and (slopes[0], slopes[-1]) == (-22.0, 22.0)
    assert all(len(panel.labels) == 84 and set(panel.labels["slope"]) == {panel.at["slope"]} for panel in slices.panels)
    assert "9 of 12 slices" in slices.remark and "1 held-out tasks lie between" in slices.remark


def test_slices_of_two_further_axes_are_those_of_the_grid(sloped_labels) -> None:
    low, high = sloped_labels["slope"].min(), sloped_labels["slope"].max()
    both = sloped_labels[sloped_labels["slope"].isin([low, high])].assign(friction=0.5)
    other = both[both["slope"] == low].assign(friction=0.8)
    slices = slices_of(pd.concat([both, other]), over("speed", "cycle_duration", "slope", "friction"))
    assert [tuple(panel.at.values()) for panel in slices.panels] == [(low, 0.5), (low, 0.8), (high, 0.5)]


def test_labels_without_a_grid_are_sliced_by_what_is_there(sloped_labels, sloped) -> None:
    (panel,) = slices_of(sloped_labels[sloped_labels["split"] == "held_out"], sloped.tasks.space).panels
    assert panel.at == {"slope": 1.7} and np.array_equal(panel.labels["speed"], [1.0])
