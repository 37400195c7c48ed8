"""Random tasks of a map, with their plans."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gaitflow.runtime import GaitMap, Plan

MOST_DRAWS = 1000


def random_plans(gait_map: GaitMap, count: int, seed: int) -> Iterator[Plan]:
    """Feasible plans of random tasks in the map's domain."""
    domain, rng, found = gait_map.manifest.domain, np.random.default_rng(seed), 0
    for _ in range(MOST_DRAWS):
        task: dict[str, Any] = {axis: float(rng.uniform(values[0], values[-1])) for axis, values in domain.axes.items()}
        if domain.contains(task) and (plan := gait_map.plan(**task)).feasible:
            yield plan
            found += 1
        if found == count:
            return
