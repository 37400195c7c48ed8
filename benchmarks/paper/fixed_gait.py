"""Optimising a motion for the gait that the map picks: the paper's two ways and ours, a method a name.

bigm_random       the paper's "gait pattern only": big-M rows, random start
bounds_random     the pattern through variable bounds, the same random start
bounds_mean       the paper's "gait pattern & state": from the mean motion of the gait's region
bounds_mean_dual  what `GaitMap.plan` does: the same mean with its multipliers
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.paper.big_m import BigMSolver
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.problem import transcribe
from gaitflow.runtime import Choice, GaitMap
from gaitflow.runtime.versions import resolve
from gaitflow.search import starts
from gaitflow.search.attempts import seed_of
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

METHODS = ("bigm_random", "bounds_random", "bounds_mean", "bounds_mean_dual")


class FixedGait:
    """All methods on one artifact, their solvers built and called once before anything is timed.

    `warm_up` is the task (v m/s, T s) of that first call. Made to be called in a child process.
    """

    def __init__(self, artifact: str, warm_up: Sequence[float]) -> None:
        self._map = GaitMap.load(artifact)
        self._scenario = scenario_of(Path(artifact))
        self._build: dict[str, float] = {}
        limit, (speed, cycle) = self._scenario.strategy.solve_time_limit, warm_up
        start = time.perf_counter()
        self._big_m = BigMSolver(transcribe(self._scenario), limit)
        self("bigm_random", speed, cycle, 0)
        self._build["bigm_random"] = time.perf_counter() - start
        start = time.perf_counter()
        self._bounds = FixedGaitSolver(transcribe(self._scenario), limit)
        self("bounds_random", speed, cycle, 0)
        self._build["bounds_random"] = self._build["bounds_mean"] = time.perf_counter() - start
        start = time.perf_counter()
        self("bounds_mean_dual", speed, cycle, 0)
        self._build["bounds_mean_dual"] = time.perf_counter() - start

    def __call__(self, method: str, speed: float, cycle_duration: float, seed: int) -> dict[str, Any]:
        """One solver call at v [m/s], T [s]: what came out, its wall time [s], and build_s, the solver's first call."""
        choice = self._map.select(speed, cycle_duration)
        if method == "bounds_mean_dual":
            result = self._plan(speed, cycle_duration)
        else:
            result = self._solve(method, choice, seed)
        return {"gait": choice.gait, "pattern": choice.pattern, **result, "build_s": self._build.get(method)}

    def _solve(self, method: str, choice: Choice, seed: int) -> dict[str, Any]:
        assert choice.pattern is not None and choice.gait is not None, "tasks are drawn inside the domain"
        pattern, speed, cycle = Pattern.from_text(choice.pattern), choice.speed, choice.cycle_duration
        if method == "bounds_mean":
            start = Start("mean", np.array(self._map.mean_start(choice.gait, cycle).primal))
        else:
            rng = np.random.default_rng(seed_of("table1", seed, speed, cycle))
            layout = self._big_m.problem.layout
            start = Start(f"random-{seed}", starts.random(self._scenario.robot, layout, speed, cycle, rng))
        solver = self._big_m if method == "bigm_random" else self._bounds
        return _result(solver.solve(pattern, speed, cycle, start))

    def _plan(self, speed: float, cycle_duration: float) -> dict[str, Any]:
        cpu = time.process_time()
        plan = self._map.plan(speed, cycle_duration, top=1)
        cpu = time.process_time() - cpu
        return {
            "gait": plan.gait,
            "pattern": plan.pattern,
            "status": "solved" if plan.path in ("fast", "fallback") else "failed",
            "solver_status": plan.tried[0][1],
            "cost": plan.cost if plan.path in ("fast", "fallback") else None,
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
