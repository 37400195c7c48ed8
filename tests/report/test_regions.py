from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from gaitflow.report.regions import GaitGrid

SPEEDS = [0.1, 0.2, 0.3, 0.4]
DURATIONS = [0.5, 1.0, 1.5]
#          T:  0.5        1.0        1.5
ROWS = (
    ("walking", "walking", "gallop"),
    ("walking", "gallop", "gallop"),
    ("gallop", "walking", "bounding"),
    ("gallop", "walking", "bounding"),
)


@pytest.fixture
def grid(map_of) -> GaitGrid:
    at = {(v, t): ROWS[i][j] for i, v in enumerate(SPEEDS) for j, t in enumerate(DURATIONS)}
    return GaitGrid.from_labels(map_of(lambda v, t: at[v, t], SPEEDS, DURATIONS).sample(frac=1, random_state=1))


def test_tasks_take_their_place_whatever_the_order_of_rows(grid: GaitGrid) -> None:
    assert [tuple(row) for row in grid.gaits] == list(ROWS)
    assert grid.names == ("bounding", "gallop", "walking")


def test_regions_do_not_join_at_corners(grid: GaitGrid) -> None:
    assert [int(region.sum()) for region in grid.regions("walking")] == [3, 2]
    assert [int(region.sum()) for region in grid.regions("gallop")] == [3, 2]
    assert grid.regions("pronking") == ()


def test_borders_are_the_gaits_along_the_edge_of_a_region(grid: GaitGrid) -> None:
    (bounding,) = grid.regions("bounding")
    assert grid.borders(bounding) == {"gallop", "walking"}
    first_walking, _ = grid.regions("walking")
    assert grid.borders(first_walking) == {"gallop"}


def test_windows_include_their_limits_in_spite_of_rounding(grid: GaitGrid) -> None:
    assert grid.window(speed=(0.1 + 0.1, 0.1 + 0.2)).sum() == 6
    assert grid.window(speed=(-np.inf, 0.3), duration=(1.0, 1.0)).sum() == 3


def test_thirds_split_the_range_not_the_number_of_values(map_of) -> None:
    grid = GaitGrid.from_labels(map_of(lambda v, t: "gallop"))
    low, middle, high = (grid.window(speed=grid.third("speed", which)).any(axis=1) for which in range(3))
    assert list(grid.speeds[low]) == [0.1, 0.3, 0.5, 0.7]
    assert list(grid.speeds[middle]) == [0.9, 1.1, 1.3, 1.5]
    assert list(grid.speeds[high]) == [1.7, 1.9, 2.1, 2.3]


def test_ties_count_apart_from_wins(labels: pd.DataFrame) -> None:
    grid = GaitGrid.from_labels(labels)
    slowest = grid.window(speed=(0.1, 0.1))
    assert (grid.best_or_tied("gallop-walk") & slowest).sum() == 6  # seven durations, one of them infeasible
    assert not (grid.best("gallop-walk") & slowest).any()


def test_infeasible_and_held_out_tasks_are_in_no_window(labels: pd.DataFrame) -> None:
    grid = GaitGrid.from_labels(labels)
    assert grid.gaits.shape == (12, 7)
    assert grid.window().sum() == 83


def test_labels_of_several_slices_are_refused(sloped_labels) -> None:
    with pytest.raises(ValueError, match="several tasks at one speed and cycle duration; pass one slice"):
        GaitGrid.from_labels(sloped_labels)


def test_labels_without_grid_tasks_are_refused(labels: pd.DataFrame) -> None:
    with pytest.raises(ValueError, match="no task of the split 'grid'"):
        GaitGrid.from_labels(labels[labels["split"] == "held_out"])
