"""`GaitMap.plan` and `select` timed by the call, in a process of their own."""

from __future__ import annotations

import time
from collections.abc import Sequence
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

    def __call__(self, tasks: Sequence[tuple[float, float]]) -> dict[str, Any]:
        """{rows, select_us, load_s, warm_up_s, warm_up_plans} of tasks (v m/s, T s), rows and select_us one a task.

        A row is `timed_plan`'s with picked and probability, what `select` says of the task; select_us is wall time [µs]
        of `select`, when it is asked the second time.
        """
        for v, t in tasks:
            self._map.select(v, t)
        select_us = []
        for v, t in tasks:
            start = time.perf_counter()
            self._map.select(v, t)
            select_us.append((time.perf_counter() - start) * 1e6)
        rows = [timed_plan(self._map, v, t) for v, t in tasks]
        for row, (v, t) in zip(rows, tasks, strict=True):
            choice = self._map.select(v, t)
            row |= {"picked": choice.gait, "probability": choice.probability}
        return {
            "rows": rows,
            "select_us": select_us,
            "load_s": self._load_s,
            "warm_up_s": self._warm_up_s,
            "warm_up_plans": self._warm_up_plans,
        }


def warm_up(gait_map: GaitMap) -> int:
    """Plan once for each gait, at the grid task where it is likeliest to be picked; how many gaits had one."""
    domain = gait_map.manifest.domain
    speeds, cycles = np.meshgrid(domain.speeds, domain.cycle_durations, indexing="ij")
    picked = gait_map.select_many(speeds, cycles)
    planned = 0
    for index in range(len(gait_map.gaits)):
        probability = np.where(picked.index == index, picked.probability, -1.0)
        at = np.unravel_index(probability.argmax(), probability.shape)
        if probability[at] >= 0:
            gait_map.plan(float(speeds[at]), float(cycles[at]))
            planned += 1
    return planned


def timed_plan(gait_map: GaitMap, speed: float, cycle_duration: float) -> dict[str, Any]:
    """One call of `plan` at v [m/s], T [s]: what came out, wall_ms by the clock around it and cpu_ms of this process.

    select_ms, predict_ms, refine_ms are the plan's own wall times. JSON data, but for infinite costs.
    """
    wall, cpu = time.perf_counter(), time.process_time()
    plan = gait_map.plan(speed, cycle_duration)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return {
        "speed": speed,
        "cycle_duration": cycle_duration,
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
