"""The solver of fixed gaits with a record of its answers: what is known is not solved again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Any

from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import GaitProblem
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Multipliers, Start
from gaitflow.store.solve_record import Solved, SolveRecord

FACTS = (
    "start", "feasible", "gave_up", "solver_status", "cost", "violation", "iterations", "wall_s", "cpu_s", "method",
)  # fmt: skip


class RecordedSolver(FixedGaitSolver):
    """`FixedGaitSolver` with the same answers; `on_solve` hears each, and whether it was known."""

    def __init__(
        self, problem: GaitProblem, time_limit: float, record: SolveRecord, on_solve: Callable[[Attempt, bool], None]
    ) -> None:
        super().__init__(problem, time_limit)
        self._record, self._on_solve = record, on_solve
        self._problem_digest = problem.scenario.problem_digest

    def solve(self, pattern: Pattern, task: Task, start: Start, fallback: bool = True) -> Attempt:
        """One solve from one start, unless the record has its answer."""
        name = self._name(pattern, task, start, fallback)
        known = self._record.find(name)
        attempt = super().solve(pattern, task, start, fallback) if known is None else self._attempt(known, task)
        if known is None:
            facts: dict[str, Any] = {fact: getattr(attempt, fact) for fact in FACTS}
            arrays = (attempt.w, attempt.multipliers.bounds, attempt.multipliers.rows)
            self._record.add(name, Solved(facts, arrays))
        self._on_solve(attempt, known is not None)
        return attempt

    def _attempt(self, known: Solved, task: Task) -> Attempt:
        w, bounds, rows = known.arrays
        trajectory = self.problem.layout.unpack(w, task.cycle_duration)
        return Attempt(**known.facts, w=w, trajectory=trajectory, multipliers=Multipliers(bounds, rows))

    def _name(self, pattern: Pattern, task: Task, start: Start, fallback: bool) -> str:
        known = start.multipliers
        text = json.dumps([self._problem_digest, pattern.text, task.values, fallback, start.name, known is not None])
        digest = hashlib.sha256(text.encode())
        for array in (start.w, *(() if known is None else (known.bounds, known.rows))):
            digest.update(array.tobytes())
        return digest.hexdigest()
