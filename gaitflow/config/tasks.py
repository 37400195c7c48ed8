"""The tasks of a scenario: the grid over the axes with a range, and random held-out tasks between its points."""

from __future__ import annotations

from itertools import product

import numpy as np

from gaitflow.config.sampling import Sampling
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Split, Task
from gaitflow.core.task_space import TaskSpace

__all__ = ["Split", "Task", "grid_of", "tasks_of"]

DECIMALS = 6  # held-out values are rounded to 1e-6 so that a task prints as it was solved
TRIES_PER_TASK = 100

Values = tuple[float, ...]  # on the axes with a range, in the order of AXES


def grid_of(scenario: Scenario) -> tuple[Task, ...]:
    """The tasks of the grid, the first axis with a range (speed) fastest, of the others the first one slowest."""
    space = scenario.tasks.space
    return _at(space, _grid(scenario), "grid")


def tasks_of(scenario: Scenario) -> tuple[Task, ...]:
    """Every task of a scenario: the grid, then the held-out tasks; of an adaptive sampling those that it begins with.

    Both run along the first axis with a range (speed) fastest, so that neighbouring speeds at the same other values
    follow each other; of the other axes the first one changes slowest. Held-out tasks are drawn uniformly inside the
    box of the ranges from `tasks.held_out_seed`, differ from one another and never lie on a grid point; asking for more
    of them keeps those drawn before. Raises ValueError when the box has too few other points.
    """
    space = scenario.tasks.space
    if scenario.tasks.adaptive is not None:
        return _at(space, _spread(scenario, scenario.tasks.adaptive), "sampled")
    grid = _grid(scenario)
    drawn = sorted(_held_out(scenario, set(grid)), key=lambda values: (*values[1:], values[0]))
    return _at(space, grid, "grid") + _at(space, drawn, "held_out")


def _at(space: TaskSpace, points: list[Values], split: Split) -> tuple[Task, ...]:
    return tuple(space.task(dict(zip(space.ranged, values, strict=True)), split) for values in points)


def _grid(scenario: Scenario) -> list[Values]:
    ranges = [values.values for values in scenario.tasks.ranges.values()]
    return [(values[-1], *values[:-1]) for values in product(*ranges[1:], ranges[0])]


def _spread(scenario: Scenario, sampling: Sampling) -> list[Values]:
    """Tasks that fill the box of the ranges evenly: points of a scrambled Sobol sequence."""
    from scipy.stats import qmc

    ranges = scenario.tasks.ranges.values()
    number = sampling.first(len(ranges))
    unit = qmc.Sobol(len(ranges), rng=sampling.seed).random_base2(max(number - 1, 1).bit_length())[:number]
    low, high = (np.array([getattr(values, end) for values in ranges]) for end in ("start", "stop"))
    return [tuple(values) for values in (low + unit * (high - low)).round(DECIMALS).tolist()]


def _held_out(scenario: Scenario, taken: set[Values]) -> list[Values]:
    settings = scenario.tasks
    low, high = ([getattr(values, end) for values in settings.ranges.values()] for end in ("start", "stop"))
    generator = np.random.default_rng(settings.held_out_seed)
    drawn: list[Values] = []
    for _ in range(TRIES_PER_TASK * settings.held_out):
        if len(drawn) == settings.held_out:
            break
        values = tuple(round(float(x), DECIMALS) for x in generator.uniform(low, high))
        inside = all(
            a <= x <= b for a, x, b in zip(low, values, high, strict=True)
        )  # rounding may step over the border
        if inside and values not in taken:
            taken.add(values)
            drawn.append(values)
    if len(drawn) < settings.held_out:
        raise ValueError(
            f"{scenario.name}: tasks.held_out = {settings.held_out}: only {len(drawn)} tasks off the grid fit between "
            f"{tuple(low)} and {tuple(high)} ({', '.join(settings.ranges)}); widen the grid or ask for fewer"
        )
    return drawn
