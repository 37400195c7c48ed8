"""Tasks (v, T): the grid of a scenario, and random held-out tasks between its points."""

from __future__ import annotations

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Split, Task

__all__ = ["Split", "Task", "tasks_of"]

DECIMALS = 6  # held-out values are rounded to 1e-6 so that a task prints as it was solved
TRIES_PER_TASK = 100


def tasks_of(scenario: Scenario) -> tuple[Task, ...]:
    """Every task of a scenario: the grid (T slowest, then v), then the held-out tasks sorted by (T, v).

    Held-out tasks are drawn uniformly inside the grid's rectangle from `tasks.held_out_seed`, differ from one another
    and never lie on a grid point; asking for more of them keeps those drawn before. Raises ValueError when the
    rectangle has too few other points.
    """
    speeds, durations = scenario.tasks.speed.values, scenario.tasks.cycle_duration.values
    grid = tuple(Task(v, t, "grid") for t in durations for v in speeds)
    return grid + _held_out(scenario, {(task.speed, task.cycle_duration) for task in grid})


def _held_out(scenario: Scenario, taken: set[tuple[float, float]]) -> tuple[Task, ...]:
    settings = scenario.tasks
    low = (settings.speed.start, settings.cycle_duration.start)
    high = (settings.speed.stop, settings.cycle_duration.stop)
    generator = np.random.default_rng(settings.held_out_seed)
    taken = set(taken)
    drawn: list[Task] = []
    for _ in range(TRIES_PER_TASK * settings.held_out):
        if len(drawn) == settings.held_out:
            break
        v, t = (round(float(x), DECIMALS) for x in generator.uniform(low, high))
        inside = low[0] <= v <= high[0] and low[1] <= t <= high[1]  # rounding may step over the border
        if inside and (v, t) not in taken:
            taken.add((v, t))
            drawn.append(Task(v, t, "held_out"))
    if len(drawn) < settings.held_out:
        raise ValueError(
            f"{scenario.name}: tasks.held_out = {settings.held_out}: only {len(drawn)} tasks off the grid fit between "
            f"{low} and {high} (speed, cycle_duration); widen the grid or ask for fewer"
        )
    return tuple(sorted(drawn, key=lambda task: (task.cycle_duration, task.speed)))
