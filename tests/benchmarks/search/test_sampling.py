"""The grids and the verdict of the bench that compares chosen tasks with uniform grids."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.search.sampling import _adaptive, _doubling, _grid, _summary
from gaitflow.config.scenario import load_scenario

SCENARIOS = Path(__file__).parents[3] / "configs/scenarios"


@pytest.mark.parametrize(("fineness", "tasks"), [(0.4, 5 * 3), (1.0, 12 * 7)])
def test_a_grid_is_uniform_over_the_whole_range(fineness: float, tasks: int) -> None:
    scenario = _adaptive(load_scenario(SCENARIOS / "half-cheetah-exact-vibration.yaml"))
    assert scenario.tasks.adaptive is not None
    grid = _grid(scenario, fineness)
    assert len(grid) == tasks and {task.split for task in grid} == {"sampled"}
    for axis, values in scenario.tasks.ranges.items():
        assert {min(task[axis] for task in grid), max(task[axis] for task in grid)} == {values.start, values.stop}


def test_the_fewest_searches_of_each_way_are_told() -> None:
    rows = [
        {"way": "adaptive", "searched": 16, "bound": 0.2},
        {"way": "adaptive", "searched": 24, "bound": 0.02},
        {"way": "grid", "searched": 24, "bound": 0.1},
        {"way": "grid", "searched": 60, "bound": 0.02},
        {"way": "grid", "searched": 84, "bound": 0.01},
    ]
    assert _summary(rows) == {"bound": 0.02, "searched_adaptive": 24, "searched_grid": 60}
    assert _summary(rows[:3])["searched_grid"] is None


def test_maps_are_judged_where_their_searches_have_doubled() -> None:
    task = _grid(_adaptive(load_scenario(SCENARIOS / "half-cheetah-exact-vibration.yaml")), 0.4)[0]
    steps = [(task,) * number for number in (32, 48, 64, 80, 96)]
    assert [len(tasks) for tasks in _doubling(steps)] == [32, 64, 96]
    assert [len(tasks) for tasks in _doubling(steps[:1])] == [32]
