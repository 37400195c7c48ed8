"""`GaitMap.plan` and one IPOPT solve from the mean motion of the picked gait's region, in turn at each task."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.online.plan_times import timed_plan, warm_up
from benchmarks.paper.fixed_gait import scenario_of
from benchmarks.search.tasks import task_of
from gaitflow.core.gaits import Pattern
from gaitflow.problem import transcribe
from gaitflow.runtime import GaitMap
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start


class PlanAndMeanStart:
    """A map that has planned once for each gait, and the IPOPT of its problem, called once."""

    def __init__(self, artifact: str) -> None:
        self._map = GaitMap.load(artifact)
        self._scenario = scenario_of(Path(artifact))
        self._solver = FixedGaitSolver(transcribe(self._scenario), self._scenario.strategy.solve_time_limit)
        warm_up(self._map)
        self._from_mean(self._map.manifest.domain.middle)

    def __call__(self, tasks: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
        """A row a task: path and CPU time of plan [ms], status and CPU time of IPOPT [ms]."""
        rows = []
        for task in tasks:
            planned = timed_plan(self._map, task)
            rows.append({"path": planned["path"], "plan_ms": planned["cpu_ms"], **self._from_mean(task)})
        return rows

    def _from_mean(self, values: Mapping[str, float]) -> dict[str, Any]:
        """The paper's 'gait pattern & state': the classifier's pick, from the mean of its region."""
        asked: Any = dict(values)
        name, _ = max(self._map.select(**asked).ranked, key=lambda each: each[1])
        gait = next(gait for gait in self._map.gaits if gait.name == name)
        task = task_of(self._scenario, values)
        start = Start("mean", np.array(self._map.mean_start(name, task.cycle_duration).primal))
        before = time.process_time()
        attempt = self._solver.solve(Pattern.from_text(gait.pattern), task, start)
        return {"ipopt_ms": (time.process_time() - before) * 1e3, "ipopt_solved": attempt.feasible}
