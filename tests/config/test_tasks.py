from __future__ import annotations

from itertools import groupby
from typing import Any

import pytest

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import grid_of, tasks_of


def changed(scenario: Scenario, axes: dict[str, Any] | None = None, **tasks: object) -> Scenario:
    data = scenario.as_data()
    data["tasks"].update(tasks)
    data["tasks"]["axes"].update(axes or {})
    return Scenario.from_data(data, "test")


def test_grid_comes_first_with_speed_fastest(scenario: Scenario) -> None:
    tasks = tasks_of(scenario)
    assert [task.split for task in tasks] == ["grid"] * 6 + ["held_out"] * 3
    grid = [(task.speed, task.cycle_duration) for task in tasks[:6]]
    assert grid == [(v, t) for t in (0.4, 1.2) for v in (0.1, 1.1, 2.1)]


def test_a_grid_of_any_axes_keeps_chains_of_speeds_together(scenario: Scenario) -> None:
    many = changed(
        scenario,
        {
            "friction": {"start": 0.5, "stop": 0.7, "count": 3},
            "slope": {"start": -20.0, "stop": 20.0, "count": 5},
            "acceleration": 0.3,
        },
    )
    grid = [task for task in tasks_of(many) if task.split == "grid"]
    others = ("cycle_duration", "slope", "friction")
    assert len(grid) == len({task.on(("speed", *others)) for task in grid}) == 3 * 2 * 5 * 3
    chains = [list(chain) for _, chain in groupby(grid, key=lambda task: task.on(others))]
    assert all([task.speed for task in chain] == [0.1, 1.1, 2.1] for chain in chains)
    assert [chain[0].on(others) for chain in chains] == sorted(chain[0].on(others) for chain in chains)
    assert {task["acceleration"] for task in tasks_of(many)} == {0.3}
    drawn = [task.on(("speed", *others)) for task in tasks_of(many) if task.split == "held_out"]
    low, high = (0.1, 0.4, -20.0, 0.5), (2.1, 1.2, 20.0, 0.7)
    assert all(a <= x <= b for values in drawn for a, x, b in zip(low, values, high, strict=True))


def test_one_axis_is_enough(scenario: Scenario) -> None:
    line = changed(scenario, {"speed": 0.9})
    grid = [task for task in tasks_of(line) if task.split == "grid"]
    assert [(task.speed, task.cycle_duration) for task in grid] == [(0.9, 0.4), (0.9, 1.2)]
    assert all(task.speed == 0.9 for task in tasks_of(line))


def test_held_out_tasks_lie_inside_off_the_grid_and_repeat(scenario: Scenario) -> None:
    many = changed(scenario, held_out=500)
    held_out = [task for task in tasks_of(many) if task.split == "held_out"]
    points = {(task.speed, task.cycle_duration) for task in held_out}
    grid = {(task.speed, task.cycle_duration) for task in tasks_of(many) if task.split == "grid"}
    assert len(points) == 500 and not points & grid
    assert all(0.1 <= v <= 2.1 and 0.4 <= t <= 1.2 for v, t in points)
    assert all(round(v, 6) == v and round(t, 6) == t for v, t in points)
    assert tasks_of(many) == tasks_of(many)
    assert points != {(t.speed, t.cycle_duration) for t in tasks_of(changed(many, held_out_seed=1))}
    # Uniform over the rectangle: the mean of 500 draws is within 5 standard errors of the centre.
    assert abs(sum(v for v, _ in points) / 500 - 1.1) < 5 * 2.0 / (12 * 500) ** 0.5


def test_asking_for_more_keeps_those_drawn_before(scenario: Scenario) -> None:
    few, more = (set(tasks_of(changed(scenario, held_out=n))) for n in (3, 9))
    assert few < more


def test_one_line_of_tasks_is_enough_to_draw_from(scenario: Scenario) -> None:
    line = changed(scenario, {"cycle_duration": {"start": 0.5, "stop": 0.5, "count": 1}})
    held_out = [task for task in tasks_of(line) if task.split == "held_out"]
    assert {task.cycle_duration for task in held_out} == {0.5} and len(held_out) == 3


def test_a_single_point_has_nothing_to_hold_out(scenario: Scenario) -> None:
    point = {"start": 0.5, "stop": 0.5, "count": 1}
    with pytest.raises(ValueError, match=r"tasks.held_out = 3: only 0 tasks off the grid fit between \(0\.5, 0\.5\)"):
        tasks_of(changed(scenario, {"speed": point, "cycle_duration": point}))


def test_an_adaptive_sampling_begins_with_tasks_spread_over_the_box(scenario: Scenario) -> None:
    adaptive = changed(scenario, sampling="adaptive", held_out=0)
    tasks = tasks_of(adaptive)
    assert len(tasks) == len(set(tasks)) == 16 and {task.split for task in tasks} == {"sampled"}
    quarters = {(task.speed > 1.1, task.cycle_duration > 0.8) for task in tasks}
    assert len(quarters) == 4 and all(0.1 <= task.speed <= 2.1 for task in tasks)
    assert tasks == tasks_of(adaptive)
    assert tasks != tasks_of(changed(scenario, sampling={"seed": 1}, held_out=0))
    assert len(tasks_of(changed(scenario, sampling={"start": 5}, held_out=0))) == 5
    assert [task.split for task in grid_of(adaptive)] == ["grid"] * 6


@pytest.mark.parametrize(
    ("tasks", "message"),
    [
        ({"sampling": "adaptive"}, "held_out = 3: with an adaptive sampling"),
        ({"sampling": "adaptative", "held_out": 0}, "tasks.sampling = 'adaptative'"),
        ({"sampling": {"most": 0}, "held_out": 0}, "tasks.sampling.most = 0"),
        ({"sampling": {"mots": 9}, "held_out": 0}, "did you mean most"),
        ({"sampling": {"dearer": 1.0}, "held_out": 0}, "tasks.sampling.dearer = 1.0"),
    ],
)
def test_a_sampling_that_cannot_be_is_refused(scenario: Scenario, tasks: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        changed(scenario, **tasks)


def test_a_sampling_needs_a_search(scenario: Scenario) -> None:
    data = scenario.as_data()
    data["tasks"] |= {"sampling": "adaptive", "held_out": 0}
    data["strategy"] = {"name": "bonmin"}
    with pytest.raises(ConfigError, match=r"tasks\.sampling: needs a search"):
        Scenario.from_data(data, "test")


def test_a_grid_is_the_same_data_as_before_there_was_a_choice(scenario: Scenario) -> None:
    assert "sampling" not in scenario.as_data()["tasks"]
    assert changed(scenario, sampling="grid") == scenario
