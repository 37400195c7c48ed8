"""What nodes tell a classifier: the cheapest gait of each task that is neither the dataset's nor a coin's toss."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from gaitflow.atlas.grow import REFINE, Grown
from gaitflow.learn.nodes import node_labels
from gaitflow.publishing import Parts
from gaitflow.runtime.atlas import Atlas

AXES = tuple(0.1 * n for n in range(5)), tuple(0.5 + 0.1 * n for n in range(5))


def atlas(*sheets: tuple[int, dict[tuple[int, int], float]]) -> Atlas:
    """Sheets by gait and the costs of their nodes, on a grid of 3 by 3 tasks with 2 steps each."""
    made = [
        SimpleNamespace(gait=gait, places=np.array(list(costs)).reshape(-1, 2), costs=np.array(list(costs.values())))
        for gait, costs in sheets
    ]
    return Atlas(*AXES, 1e-4, tuple(made))


def test_the_cheapest_gait_labels_a_node_by_any_of_its_sheets() -> None:
    found = node_labels(
        atlas((0, {(0, 1): 3.0, (1, 1): 1.0}), (1, {(0, 1): 2.0, (1, 1): 2.0}), (0, {(0, 1): 1.5})), 0.01, 2
    )
    np.testing.assert_allclose(found.tasks, [[0.0, 0.6], [0.1, 0.6]], rtol=1e-6)
    assert found.gaits.tolist() == [0, 0]
    assert (found.tasks.dtype, found.gaits.dtype) == (np.float32, np.int64)


def test_the_datasets_own_tasks_and_ties_are_left_out() -> None:
    one = {(0, 0): 1.0, (2, 4): 1.0, (2, 1): 1.0, (1, 2): 1.0, (3, 3): 1.0}
    other = {(2, 1): 1.009, (1, 2): 1.02}
    found = node_labels(atlas((0, one), (1, other)), 0.01, 2)
    np.testing.assert_allclose(found.tasks, [[0.1, 0.7], [0.3, 0.8]], rtol=1e-6)


def test_cells_are_those_of_the_maps_grid() -> None:
    places = [(1, 1), (0, 1), (1, 0), (3, 1), (1, 3), (3, 3)]
    found = node_labels(atlas((0, dict.fromkeys(places, 1.0))), 0.01, 2)
    cell = dict(zip(sorted(places), found.cells.tolist(), strict=True))
    assert cell[1, 1] == cell[0, 1] == cell[1, 0]
    assert len({cell[place] for place in ((1, 1), (3, 1), (1, 3), (3, 3))}) == 4


def test_an_atlas_without_nodes_tells_nothing() -> None:
    found = node_labels(Atlas.empty(), 0.01)
    assert (found.tasks.shape, found.gaits.shape, found.cells.shape) == ((0, 2), (0,), (0,))


def test_a_real_atlas_labels_walking_below_gallop(parts: Parts, grown: Grown) -> None:
    found = node_labels(parts.atlas, 0.01)
    assert len(found.tasks) > 150
    tasks = {tuple(task) for task in found.tasks.tolist()}
    coarse = parts.problem.scenario.tasks
    assert not tasks & {
        (float(np.float32(v)), float(np.float32(t))) for v in coarse.speed.values for t in coarse.cycle_duration.values
    }
    assert found.tasks[found.gaits == 0, 0].mean() < found.tasks[found.gaits == 1, 0].mean()
    for place, node in grown.nodes[0].items():
        other = grown.nodes[1].get(place)
        if other is None or not (place[0] % REFINE or place[1] % REFINE) or abs(other.cost / node.cost - 1) < 0.02:
            continue
        task = np.float32([grown.speeds[place[0]], grown.cycle_durations[place[1]]])
        (row,) = np.flatnonzero((found.tasks == task).all(axis=1))
        assert found.gaits[row] == (0 if node.cost < other.cost else 1)
