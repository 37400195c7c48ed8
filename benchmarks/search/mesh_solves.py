"""One gait at one task by one transcription, from the nominal start; made to be called in a child process."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.search.tasks import task_of
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.search.resolve import interpolated
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start


class MeshSolves:
    """A scenario's solver; with `coarse`, the same scenario on another mesh, also from the motions there."""

    def __init__(self, scenario: Mapping[str, Any], coarse: Mapping[str, Any] | None = None) -> None:
        self._scenario = Scenario.from_data(scenario, "the bench's scenario")
        self._solver = _solver_of(self._scenario)
        given = None if coarse is None else Scenario.from_data(coarse, "the bench's scenario, coarse")
        self._coarse = None if given is None else _solver_of(given)

    def __call__(self, task: Mapping[str, float], pattern: str) -> dict[str, Any]:
        """The solve, building excluded; cost is None without a motion."""
        wanted, gait = task_of(self._scenario, task), Pattern.from_text(pattern)
        self._solver.method(gait)  # orders its matrix
        attempts = [_nominal(self._solver, gait, wanted)]
        if self._coarse is not None:
            before = _nominal(self._coarse, gait, wanted)
            if before.feasible:
                layouts = self._coarse.problem.layout, self._solver.problem.layout
                w = layouts[1].pack(interpolated(before.trajectory, *layouts), wanted.cycle_duration)
                attempts.append(self._solver.solve(gait, wanted, Start("coarser", w)))
        best = min(attempts, key=lambda attempt: (not attempt.feasible, attempt.cost))
        return {
            "feasible": best.feasible,
            "cost": best.cost if best.feasible else None,
            "iterations": sum(attempt.iterations for attempt in attempts),
            "cpu_s": sum(attempt.cpu_s for attempt in attempts),
            "method": best.method,
        }


def _solver_of(scenario: Scenario) -> FixedGaitSolver:
    """Built, and called once: what is built at a first call does not count."""
    solver = FixedGaitSolver(transcribe(scenario), scenario.strategy.solve_time_limit)
    legs, phases = len(scenario.robot.legs), scenario.transcription.phases
    task = scenario.tasks.space.task({axis: each.values[0] for axis, each in scenario.tasks.ranges.items()})
    _nominal(solver, Pattern(("1" * (phases - 1) + "0",) * legs), task)
    return solver


def _nominal(solver: FixedGaitSolver, pattern: Pattern, task: Task) -> Attempt:
    problem = solver.problem
    return solver.solve(pattern, task, Start("nominal", starts.nominal(problem.scenario.robot, problem.layout, task)))
