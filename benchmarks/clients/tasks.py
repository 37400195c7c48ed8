"""Random tasks of a map, with their plans: anywhere in its domain, or as a planner would ask."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gaitflow.runtime import GaitMap, Plan

MOST_DRAWS = 1000
AROUND = 0.25  # of the cycle duration that the map would choose, to both sides


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


def asked_plans(gait_map: GaitMap, count: int, seed: int) -> Iterator[Plan]:
    """Feasible plans of random speeds, with the cycle duration that the map chooses, more or less."""
    domain, rng, found = gait_map.manifest.domain, np.random.default_rng(seed), 0
    for _ in range(MOST_DRAWS):
        task: dict[str, Any] = {axis: float(rng.uniform(values[0], values[-1])) for axis, values in domain.axes.items()}
        del task["cycle_duration"]
        chosen = gait_map.select(**task).cycle_duration
        task["cycle_duration"] = float(chosen * rng.uniform(1 - AROUND, 1 + AROUND))
        if domain.contains(task) and (plan := gait_map.plan(**task)).feasible:
            yield plan
            found += 1
        if found == count:
            return
