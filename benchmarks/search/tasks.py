"""Tasks of a bench: chosen from a scenario's grid, and as the part of a row that says which task it is of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Split, Task


def gridded(scenario: Scenario) -> Scenario:
    """The scenario with all tasks of its grid, also where its map chooses its own."""
    return scenario.model_copy(update={"tasks": scenario.tasks.model_copy(update={"sampling": "grid"})})


def task_key(scenario: Scenario, task: Task) -> dict[str, float]:
    """The task's values by axis, on speed, cycle_duration and whatever else the scenario ranges over."""
    return {axis: task[axis] for axis in scenario.tasks.space.columns}


def task_values(scenario: Scenario, row: Mapping[Any, Any]) -> dict[str, float]:
    """The fields of a row that `task_key` gave it."""
    return {axis: float(row[axis]) for axis in scenario.tasks.space.columns}


def task_of(scenario: Scenario, row: Mapping[Any, Any], split: Split = "grid") -> Task:
    """The task of a row that has `task_key`'s fields. Raises KeyError without one, ValueError for another scenario."""
    return scenario.tasks.space.task(task_values(scenario, row), split)


def middle(scenario: Scenario) -> Task:
    """The task in the middle of the grid."""
    ranges = scenario.tasks.ranges
    return scenario.tasks.space.task({axis: each.values[each.count // 2] for axis, each in ranges.items()})


def spread_tasks(scenario: Scenario, count: int, seed: int) -> tuple[Task, ...]:
    """`count` different tasks of the grid: a random Latin hypercube, so that they spread over every axis.

    Raises ValueError when the grid has fewer, or for a count below 1.
    """
    axes = {axis: each.values for axis, each in scenario.tasks.ranges.items()}
    size = math.prod(map(len, axes.values()))
    if not 1 <= count <= size:
        raise ValueError(f"tasks = {count}: {scenario.name} has a grid of {size} to draw from")
    rng = np.random.default_rng(seed)
    drawn: dict[Task, None] = {}
    while len(drawn) < count:
        places = [(rng.permutation(count) + rng.random(count)) / count for _ in axes]
        for at in zip(*places, strict=True):
            chosen = {axis: values[int(x * len(values))] for (axis, values), x in zip(axes.items(), at, strict=True)}
            drawn[scenario.tasks.space.task(chosen)] = None
    return tuple(list(drawn)[:count])
