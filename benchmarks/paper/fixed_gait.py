"""Optimising a motion for the gait that the map picks: the paper's two ways and ours, a method a name.

bigm_random       the paper's "gait pattern only": big-M rows, random start
bounds_random     the pattern through variable bounds, the same random start
bounds_mean       the paper's "gait pattern & state": from the mean motion of the gait's region
bounds_mean_dual  what `GaitMap.plan` does: the same mean with its multipliers
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.paper.big_m import BigMSolver
from benchmarks.search.tasks import task_of
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.problem import transcribe
from gaitflow.runtime import GaitMap
from gaitflow.runtime.manifest import Gait
from gaitflow.runtime.versions import resolve
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

METHODS = ("bigm_random", "bounds_random", "bounds_mean", "bounds_mean_dual")


class FixedGait:
    """All methods on one artifact, their solvers built and called once before anything is timed.

    `warm_up` is the task of that first call, its values by axis. Made to be called in a child process.
    """

    def __init__(self, artifact: str, warm_up: Mapping[str, float]) -> None:
        self._map = GaitMap.load(artifact)
        self._scenario = scenario_of(Path(artifact))
        self._build: dict[str, float] = {}
        limit = self._scenario.strategy.solve_time_limit
        start = time.perf_counter()
        self._big_m = BigMSolver(transcribe(self._scenario), limit)
        self("bigm_random", warm_up, 0)
        self._build["bigm_random"] = time.perf_counter() - start
        start = time.perf_counter()
        self._bounds = FixedGaitSolver(transcribe(self._scenario), limit)
        self("bounds_random", warm_up, 0)
        self._build["bounds_random"] = self._build["bounds_mean"] = time.perf_counter() - start
        start = time.perf_counter()
        self("bounds_mean_dual", warm_up, 0)
        self._build["bounds_mean_dual"] = time.perf_counter() - start

    def __call__(self, method: str, task: Mapping[str, float], seed: int) -> dict[str, Any]:
        """One solver call at a task: what came out, its wall time [s], and build_s, that of the solver's first call."""
        gait = self._picked(task)
        result = self._plan(task) if method == "bounds_mean_dual" else self._solve(method, gait, task, seed)
        return {"gait": gait.name, "pattern": gait.pattern, **result, "build_s": self._build.get(method)}

    def _picked(self, task: Mapping[str, float]) -> Gait:
        """The classifier's pick, as in the paper; `plan` goes by predicted costs."""
        asked: Any = dict(task)
        name, _ = max(self._map.select(**asked).ranked, key=lambda each: each[1])
        return next(gait for gait in self._map.gaits if gait.name == name)

    def _solve(self, method: str, gait: Gait, values: Mapping[str, float], seed: int) -> dict[str, Any]:
        task = task_of(self._scenario, values)
        if method == "bounds_mean":
            start = Start("mean", np.array(self._map.mean_start(gait.name, task.cycle_duration).primal))
        else:
            rng = np.random.default_rng(starts.seed_of("table1", seed, *task.values))
            layout = self._big_m.problem.layout
            start = Start(f"random-{seed}", starts.random(self._scenario.robot, layout, task, rng))
        solver = self._big_m if method == "bigm_random" else self._bounds
        return _result(solver.solve(Pattern.from_text(gait.pattern), task, start))

    def _plan(self, task: Mapping[str, float]) -> dict[str, Any]:
        asked: Any = dict(task)
        cpu = time.process_time()
        plan = self._map.plan(**asked, top=1)
        cpu = time.process_time() - cpu
        solved = plan.path in ("fast", "fallback")
        return {
            "gait": plan.gait,
            "pattern": plan.pattern,
            "status": "solved" if solved else "failed",
            "solver_status": plan.tried[0][1],
            "cost": plan.cost if solved else None,
            "violation": plan.violation,
            "iterations": plan.iterations,
            "wall_s": plan.time_ms / 1e3,
            "cpu_s": cpu,
        }


def scenario_of(artifact: Path) -> Scenario:
    """The scenario that an artifact was made for. Raises ArtifactError, ConfigError."""
    manifest = GaitMap.load(artifact).manifest
    return Scenario.from_data(dict(manifest.scenario), str(resolve(artifact) / "manifest.json"))


def _result(attempt: Attempt) -> dict[str, Any]:
    return {
        "status": "solved" if attempt.feasible else "failed" if attempt.gave_up else "infeasible",
        "solver_status": attempt.solver_status,
        "cost": attempt.cost if attempt.feasible else None,
        "violation": attempt.violation,
        "iterations": attempt.iterations,
        "wall_s": attempt.wall_s,
        "cpu_s": attempt.cpu_s,
    }
