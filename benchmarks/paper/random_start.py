"""`GaitMap.plan` and the paper's ways to a motion of a picked gait, one after the other on each task.

Task by task in one process, so that what else the machine does meets all of them alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks import child
from benchmarks.online import plan_times
from benchmarks.online.plan_times import timed_plan, warm_up
from benchmarks.paper import big_m, fixed_gait
from benchmarks.paper.fixed_gait import FixedGait
from benchmarks.rows import Row, RowStore
from benchmarks.search.search import LOST
from benchmarks.search.tasks import task_key, task_values
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.files import sha256_file
from gaitflow.runtime import GaitMap, atlas, gait_map, nearby, plan, problem, refine, rivals
from gaitflow.runtime.versions import resolve
from gaitflow.solvers import interior_point, kkt, options, point, program

PLAN = "plan"
PAPER = "bigm_random"
METHODS = (PLAN, "bounds_mean", "bounds_random", PAPER)
_MODULES = (fixed_gait, big_m, plan_times, atlas, nearby, gait_map, interior_point, kkt, plan, point, problem, program,
            refine, rivals, options)  # fmt: skip


class PlanAndFixedGait:
    """`plan` and the methods of `fixed_gait` on one artifact, all called before anything is timed."""

    def __init__(self, artifact: str, warm_up_task: Mapping[str, float]) -> None:
        self._fixed_gait = FixedGait(artifact, warm_up_task)
        self._map = GaitMap.load(artifact)
        warm_up(self._map)

    def __call__(self, method: str, task: Mapping[str, float], seed: int) -> dict[str, Any]:
        """One call at a task, its values by axis: what came out (no cost unless it is solved), and its times [s]."""
        if method == PLAN:
            found = timed_plan(self._map, task)
            solved = found["path"] != "failed"
            found |= {"status": "solved" if solved else "failed", "cost": found["cost"] if solved else None}
            found |= {"wall_s": found["wall_ms"] / 1e3, "cpu_s": found["cpu_ms"] / 1e3}
        else:
            found = self._fixed_gait(method, task, seed)
        return {key: found[key] for key in ("gait", "pattern", "status", "cost", "iterations", "wall_s", "cpu_s")}


def calls_by_method(
    bench: str, scenario: Scenario, artifact: Path, tasks: Sequence[Task], warm_up_task: Task, seed: int, runs: Path
) -> list[dict[str, Row]]:
    """A call of each of METHODS a task, by name; a task that was measured before, kept below `runs`, is reused."""
    about = {"manifest": sha256_file(resolve(artifact) / "manifest.json")}
    limit = 10 * scenario.strategy.solve_time_limit  # wall time: the machine may be busy
    setup = {"artifact": str(artifact), "warm_up_task": task_key(scenario, warm_up_task)}
    keys = [task_key(scenario, task) | {"methods": list(METHODS), "seed": seed} for task in tasks]
    with child.Child("benchmarks.paper.random_start:PlanAndFixedGait", setup) as process:

        def measure(key: Row) -> Row:
            request = {"task": task_values(scenario, key), "seed": seed}
            return {"calls": {method: _call(process, limit, {"method": method} | request) for method in METHODS}}

        rows = RowStore(bench, scenario, runs, _MODULES, about).rows(keys, measure)
    return [row["calls"] for row in rows]


def _call(process: child.Child, limit_s: float, request: Row) -> Row:
    try:
        return dict(process.call(limit_s, **request))
    except child.Lost as lost:
        nothing = dict.fromkeys(("gait", "pattern", "cost", "iterations"))
        return {**nothing, "status": LOST, "wall_s": lost.wall_s, "cpu_s": lost.cpu_s}
