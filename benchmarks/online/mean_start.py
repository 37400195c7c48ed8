"""`GaitMap.plan`, the C++ planner, and one IPOPT solve from the picked gait's mean motion, in turn at each task."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.online.cpp import AskedInTurn, line_of
from benchmarks.online.plan_times import timed_plan, warm_up
from benchmarks.paper.fixed_gait import scenario_of
from benchmarks.search.tasks import task_of
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern
from gaitflow.problem import transcribe
from gaitflow.runtime import GaitMap
from gaitflow.solvers.ipopt import call_solver, make_ipopt
from gaitflow.solvers.options import CONVERGED, IPOPT


class PlanAndMeanStart:
    """A map that has planned once for each gait, the same compiled, and the IPOPT of its problem, called once.

    planner is the command of the map's C++ planner, a process beside this one.
    """

    def __init__(self, artifact: str, compiled: str, planner: Sequence[str]) -> None:
        self._map, self._compiled = GaitMap.load(artifact), GaitMap.load(artifact, compiled=compiled)
        scenario = scenario_of(Path(artifact))
        self._problem = transcribe(scenario)
        self._ipopt = make_ipopt(self._problem.nlp, IPOPT | {"max_cpu_time": scenario.strategy.solve_time_limit})
        warm_up(self._map)
        warm_up(self._compiled)
        self._cpp = AskedInTurn(planner)
        self._cpp(line_of(self._map.manifest.domain.middle, self._map.axes))
        self._from_mean(self._map.manifest.domain.middle)

    def __call__(self, tasks: Sequence[Mapping[str, Any]], by_ipopt: int) -> list[dict[str, Any]]:
        """A row a task: path, cost and CPU time [ms] of a plan, the same compiled, and both of the gait alone that the
        map picks before anything is solved; cpp_ms and cpp_refined; of the first `by_ipopt` tasks also what
        `_from_mean` says.
        """
        rows = []
        for number, task in enumerate(tasks):
            plans = {"plan": timed_plan(self._map, task), "compiled": timed_plan(self._compiled, task)}
            alone = {**task, "gait": plans["plan"]["first"]}
            plans |= {"alone": timed_plan(self._map, alone), "compiled_alone": timed_plan(self._compiled, alone)}
            answer = self._cpp(line_of(task, self._map.axes))
            cpp = {"cpp_ms": answer["cpu_us"] / 1e3, "cpp_refined": answer["refined"]}
            ipopt = self._from_mean(task) if number < by_ipopt else {}
            kept = {"path": "path", "cost": "cost", "ms": "cpu_ms"}
            told = {f"{way}_{name}": each[key] for way, each in plans.items() for name, key in kept.items()}
            rows.append(told | cpp | ipopt)
        return rows

    def _from_mean(self, values: Mapping[str, float]) -> dict[str, Any]:
        """The paper's 'gait pattern & state': the classifier's pick, from the mean of its region.

        ipopt_ms is the CPU time of the solve. It counts as solved where IPOPT converged and our check finds the motion
        feasible.
        """
        asked: Any = dict(values)
        name, _ = max(self._map.select(**asked).ranked, key=lambda each: each[1])
        pattern = Pattern.from_text(next(gait.pattern for gait in self._map.gaits if gait.name == name))
        scenario, bounds = self._problem.scenario, self._problem.bounds(pattern)
        task = task_of(scenario, values)
        arguments: dict[str, Any] = {
            "x0": np.array(self._map.mean_start(name, task.cycle_duration).primal),
            "p": task.parameters,
            "lbx": bounds.lower,
            "ubx": bounds.upper,
            "lbg": bounds.lower_rows,
            "ubg": bounds.upper_rows,
        }
        before = time.process_time()
        status, _, result = call_solver(self._ipopt, arguments)
        spent = time.process_time() - before
        motion = self._problem.layout.unpack(result["x"], task.cycle_duration)
        violation = worst(scenario.as_data(), motion, task, pattern.text)
        return {"ipopt_ms": spent * 1e3, "ipopt_solved": status in CONVERGED and violation <= FEASIBLE}
