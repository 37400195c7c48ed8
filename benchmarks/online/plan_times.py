"""`GaitMap.plan` and `select` timed by the call, in a process of their own."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gaitflow.runtime import GaitMap


class PlanTimes:
    """A map that has planned one task of each of its gaits before anything is timed."""

    def __init__(self, artifact: str) -> None:
        start = time.perf_counter()
        self._map = GaitMap.load(artifact)
        self._load_s = time.perf_counter() - start
        start = time.perf_counter()
        self._warm_up_plans = warm_up(self._map)
        self._warm_up_s = time.perf_counter() - start

    def __call__(self, tasks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """{rows, select_us, load_s, warm_up_s, warm_up_plans} of tasks by axis, rows and select_us one a task.

        A row is `timed_plan`'s with picked and probability, what `select` says of the task; select_us is wall time [µs]
        of `select`, when it is asked the second time.
        """
        for task in tasks:
            self._map.select(**task)
        select_us = []
        for task in tasks:
            start = time.perf_counter()
            self._map.select(**task)
            select_us.append((time.perf_counter() - start) * 1e6)
        rows = [timed_plan(self._map, task) for task in tasks]
        for row, task in zip(rows, tasks, strict=True):
            choice = self._map.select(**task)
            row |= {"picked": choice.gait, "probability": choice.probability}
        return {
            "rows": rows,
            "select_us": select_us,
            "load_s": self._load_s,
            "warm_up_s": self._warm_up_s,
            "warm_up_plans": self._warm_up_plans,
        }


def warm_up(gait_map: GaitMap) -> int:
    """Plan once for each gait, at the grid task that picks it where it is likeliest; how many gaits had one."""
    axes = gait_map.manifest.domain.axes
    grid = dict(zip(axes, np.meshgrid(*axes.values(), indexing="ij"), strict=True))
    picked = gait_map.select_many(**grid)
    planned = 0
    for index in range(len(gait_map.gaits)):
        probability = np.where(picked.index == index, picked.probability, -1.0)
        at = np.unravel_index(probability.argmax(), probability.shape)
        if probability[at] >= 0:
            task: dict[str, Any] = {axis: float(values[at]) for axis, values in grid.items()}
            gait_map.plan(**task)
            planned += 1
    return planned


def timed_plan(gait_map: GaitMap, task: Mapping[str, Any]) -> dict[str, Any]:
    """One call of `plan` at a task: what came out, wall_ms by the clock around it and cpu_ms of this process.

    first is the gait that was tried first; select_ms, predict_ms, refine_ms are the plan's own wall times. JSON data,
    but for infinite costs.
    """
    wall, cpu = time.perf_counter(), time.process_time()
    plan = gait_map.plan(**task)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return {
        **task,
        "first": plan.tried[0][0],
        "gait": plan.gait,
        "pattern": plan.pattern,
        "path": plan.path,
        "feasible": plan.feasible,
        "cost": plan.cost,
        "violation": plan.violation,
        "iterations": plan.iterations,
        "wall_ms": wall * 1e3,
        "cpu_ms": cpu * 1e3,
        "select_ms": plan.select_ms,
        "predict_ms": plan.predict_ms,
        "refine_ms": plan.refine_ms,
    }
