from __future__ import annotations

import pytest
from tasks_at import at

from benchmarks.search.search import bonmin
from benchmarks.search.tasks import gridded, middle, spread_tasks, task_key, task_of
from gaitflow.config.scenario import Range, Scenario, Tasks
from gaitflow.config.tasks import grid_of, tasks_of


def test_tasks_are_on_the_grid_spread_over_it_and_repeatable(scenario: Scenario) -> None:
    speeds, durations = (scenario.tasks.ranges[axis].values for axis in ("speed", "cycle_duration"))
    for seed in range(5):
        drawn = spread_tasks(scenario, 3, seed)
        assert drawn == spread_tasks(scenario, 3, seed)
        assert sorted(speeds.index(task.speed) // 2 for task in drawn) == [0, 1, 2], "one in each third of the speeds"
        assert len({task.cycle_duration for task in drawn}) >= 2
        assert all(task.cycle_duration in durations for task in drawn)
    assert len({spread_tasks(scenario, 3, seed) for seed in range(5)}) > 1
    assert len(set(spread_tasks(scenario, 24, 0))) == 24


@pytest.mark.parametrize("count", [0, 25])
def test_more_tasks_than_the_grid_has_are_refused(scenario: Scenario, count: int) -> None:
    with pytest.raises(ValueError, match=f"tasks = {count}: quickstart has a grid of 24"):
        spread_tasks(scenario, count, 0)


def _with_axes(scenario: Scenario) -> Scenario:
    """Speed and slope with a range, one cycle duration."""
    axes = {
        "speed": Range(start=-0.5, stop=0.5, count=3),
        "cycle_duration": 0.7,
        "slope": Range(start=0.0, stop=20.0, count=5),
        "friction": 0.6,
    }
    return scenario.model_copy(update={"tasks": Tasks(axes=axes)})


def test_a_row_tells_its_task_on_every_axis_with_a_range(scenario: Scenario) -> None:
    sloped = _with_axes(scenario)
    task = at(0.5, 0.7, slope=15.0, friction=0.6)
    key = task_key(sloped, task)
    assert key == {"speed": 0.5, "cycle_duration": 0.7, "slope": 15.0}
    assert task_of(sloped, key | {"method": "patterns"}) == task
    with pytest.raises(KeyError, match="slope"):
        task_of(sloped, {"speed": 0.5, "cycle_duration": 0.7})
    with pytest.raises(ValueError, match=r"cycle_duration = 0\.9: it is fixed at 0\.7"):
        task_of(sloped, key | {"cycle_duration": 0.9})


def test_tasks_spread_over_every_axis_with_a_range(scenario: Scenario) -> None:
    drawn = spread_tasks(_with_axes(scenario), 5, 0)
    assert {task["slope"] for task in drawn} == {0.0, 5.0, 10.0, 15.0, 20.0}
    assert {(task.cycle_duration, task["friction"]) for task in drawn} == {(0.7, 0.6)}
    assert len(spread_tasks(_with_axes(scenario), 15, 0)) == 15
    assert middle(_with_axes(scenario)) == at(0.0, 0.7, slope=10.0, friction=0.6)


def test_a_bench_has_the_grid_of_a_scenario_whose_map_chooses_its_tasks(scenario: Scenario) -> None:
    chosen = scenario.model_copy(update={"tasks": Tasks(axes=scenario.tasks.axes, sampling="adaptive")})
    assert {task.split for task in tasks_of(chosen)} == {"sampled"}
    assert tasks_of(gridded(chosen)) == grid_of(scenario)
    assert bonmin(gridded(chosen)).as_data()["strategy"]["name"] == "bonmin", "a search that no sampling takes"
