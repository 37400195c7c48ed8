from __future__ import annotations

from dataclasses import astuple

import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of


def changed(scenario: Scenario, **tasks: object) -> Scenario:
    data = scenario.as_data()
    data["tasks"].update(tasks)
    return Scenario.from_data(data, "test")


def test_grid_comes_first_with_speed_fastest(scenario: Scenario) -> None:
    grid = [astuple(task) for task in tasks_of(scenario) if task.split == "grid"]
    assert grid == [(v, t, "grid") for t in (0.4, 1.2) for v in (0.1, 1.1, 2.1)]


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
    line = changed(scenario, cycle_duration={"start": 0.5, "stop": 0.5, "count": 1})
    held_out = [task for task in tasks_of(line) if task.split == "held_out"]
    assert {task.cycle_duration for task in held_out} == {0.5} and len(held_out) == 3


def test_a_single_point_has_nothing_to_hold_out(scenario: Scenario) -> None:
    point = {"start": 0.5, "stop": 0.5, "count": 1}
    with pytest.raises(ValueError, match=r"tasks.held_out = 3: only 0 tasks off the grid fit"):
        tasks_of(changed(scenario, speed=point, cycle_duration=point))
