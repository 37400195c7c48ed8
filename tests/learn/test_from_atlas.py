"""What an atlas tells a classifier: the cheapest gait of tasks that are neither the dataset's nor a coin's toss."""

from __future__ import annotations

import numpy as np
import pytest
from sheets import AXES, STEPS, sheet
from tiny_map import TinyMap, tiny_domain

from gaitflow.core.domain import Domain
from gaitflow.learn.from_atlas import atlas_labels, picks
from gaitflow.runtime.atlas import Atlas

SIZE = 5


def domain() -> Domain:
    axes = {axis: tuple((np.arange(SIZE) * step).tolist()) for axis, step in zip(AXES, STEPS, strict=True)}
    return Domain(axes, np.ones((SIZE, SIZE), dtype=bool))


def plane(gait: int, along: float, at_zero: float = 0.0):  # type: ignore[no-untyped-def]
    """A sheet whose log cost rises evenly along the first axis."""
    tasks = np.array([(i * STEPS[0], j * STEPS[1]) for i in range(SIZE) for j in range(SIZE)])
    costs = np.exp(at_zero + along * tasks[:, 0])
    return sheet(tasks, costs, np.column_stack([np.full(len(tasks), along), np.zeros(len(tasks))]), gait=gait)


def crossing() -> Atlas:
    """Gait 0 is the cheaper one below 0.43, gait 1 above."""
    return Atlas(AXES, STEPS, 1e-4, (plane(0, 1.0), plane(1, 0.0, 0.43)))


def test_the_cheapest_gait_labels_a_task() -> None:
    found = atlas_labels(crossing(), domain(), 1e-3)
    assert (found.tasks.dtype, found.gaits.dtype) == (np.float32, np.int64)
    np.testing.assert_array_equal(found.gaits, (found.tasks[:, 0] > 0.43).astype(int))
    assert set(found.gaits) == {0, 1}


def test_the_datasets_own_tasks_and_ties_are_left_out() -> None:
    found = atlas_labels(crossing(), domain(), 1e-3)
    assert len(found.tasks) == 17 * 17 - SIZE * SIZE, "four steps for each of the grid's, without its own tasks"
    near = atlas_labels(crossing(), domain(), 0.05)
    assert not (np.abs(near.tasks[:, 0] - 0.43) < 0.048).any() and len(near.tasks) < len(found.tasks)


def test_cells_are_those_of_the_maps_grid() -> None:
    found = atlas_labels(crossing(), domain(), 1e-3)
    places = np.minimum((found.tasks / STEPS + 1e-6).astype(int), SIZE - 2)
    by_cell = {cell: set(map(tuple, places[found.cells == cell].tolist())) for cell in set(found.cells.tolist())}
    assert all(len(each) == 1 for each in by_cell.values())
    assert len(by_cell) == (SIZE - 1) ** 2


@pytest.mark.parametrize("most", [10, 60, 100, 288])
def test_there_are_no_more_tasks_than_wanted(most: int) -> None:
    found = atlas_labels(crossing(), domain(), 1e-3, most)
    assert 0.4 * most < len(found.tasks) <= most
    assert found.tasks.tolist() == atlas_labels(crossing(), domain(), 1e-3, most).tasks.tolist()


def test_an_atlas_without_nodes_tells_nothing() -> None:
    found = atlas_labels(Atlas.empty(AXES), domain(), 0.01)
    assert (found.tasks.shape, found.gaits.shape, found.cells.shape) == ((0, 2), (0,), (0,))


def test_a_map_of_one_axis_has_tasks_between_those_of_its_grid() -> None:
    tasks = np.arange(SIZE)[:, None] * STEPS[:1]
    line = sheet(tasks, np.ones(SIZE), np.zeros((SIZE, 1)))
    whole = Domain({"speed": tuple(tasks[:, 0].tolist())}, np.ones(SIZE, dtype=bool))
    found = atlas_labels(Atlas(("speed",), STEPS[:1], 1e-4, (line,)), whole, 1e-3)
    assert found.tasks.shape == (12, 1)


def test_a_real_atlas_labels_walking_below_gallop(tiny: TinyMap) -> None:
    found = atlas_labels(tiny.atlas, tiny_domain(), 0.01)
    assert len(found.tasks) > 100
    assert found.tasks[found.gaits == 0, 0].mean() < found.tasks[found.gaits == 1, 0].mean()


def test_picks_go_by_cost_where_the_atlas_knows_it_and_by_probability_elsewhere() -> None:
    places = np.array([[0.1, 0.1], [0.7, 0.1], [50.0, 50.0]])
    probabilities = np.array([[0.1, 0.2, 0.7]] * 3)
    assert picks(crossing(), places, probabilities).tolist() == [[0, 1, 2], [1, 0, 2], [2, 1, 0]]
