"""Random tasks of a map's domain, equally likely anywhere in it."""

from __future__ import annotations

from itertools import count

import numpy as np

from gaitflow.core.domain import Domain
from gaitflow.core.task import Split, Task
from gaitflow.core.task_space import TaskSpace

DECIMALS = 6  # so that a task prints as it was solved
TRIES = 1_000_000  # tasks of the box, for the first one of the domain


class EmptyDomain(ValueError):
    """No task lies inside the domain, so a map that answers nowhere cannot be judged."""


def draw_tasks(domain: Domain, space: TaskSpace, number: int, seed: int, split: Split, skip: int = 0) -> list[Task]:
    """`number` tasks drawn uniformly from a domain, after the first `skip` of the same seed.

    Raises EmptyDomain when none is found.
    """
    generator = np.random.default_rng(seed)
    low, high = ([values[end] for values in domain.axes.values()] for end in (0, -1))
    found: list[Task] = []
    for tried in count():
        if len(found) == skip + number:
            return found[skip:]
        values = dict(zip(domain.axes, generator.uniform(low, high).round(DECIMALS).tolist(), strict=True))
        if domain.contains(values):
            found.append(space.task(values, split))
        elif tried == TRIES and not found:
            raise EmptyDomain(
                f"none of {TRIES} random tasks between {tuple(low)} and {tuple(high)} ({', '.join(domain.axes)}) lies "
                "inside the domain: the scenario has no region with a motion; change its axes or its robot"
            )
    raise AssertionError("the loop ends by itself")
