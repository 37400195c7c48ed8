"""Exhaustive search, ours: solve every pattern of a task that cannot be ruled out, each from its neighbour.

Where the paper restarts a MINLP, we try all canonical patterns: in the plane 36 with one stance per leg, in space
2,628, and about half as many where time can run backwards. A chain of neighbouring tasks is solved in order, so that a
pattern starts, primal and dual, from its solution at the task before. The best few gaits of a task are then solved
again from another start.

A search can be cut into parts, and an incumbent's cost, known from elsewhere, rules out what costs more for certain:
what then remains to be solved is a certificate that the incumbent is the best, or finds what is better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search.attempts import best_of, leaders, neighbouring, recheck, until_feasible
from gaitflow.search.bound import ruled_out
from gaitflow.search.resolve import FinerMeshes
from gaitflow.search.rows import solution, unsolved
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, NewSolver

RECHECKED_GAITS = 3


def candidate_patterns(scenario: Scenario, task: Task) -> tuple[Pattern, ...]:
    """The patterns to try at a task: the given one (fixed_gait), or this part of its representatives."""
    strategy = scenario.strategy
    if strategy.pattern is not None:
        return (Pattern.from_text(strategy.pattern),)
    every = _representatives(
        len(scenario.robot.legs), scenario.transcription.phases, scenario.stances_per_leg, scenario.symmetry(task)
    )
    part, parts = strategy.part or (0, 1)
    return every[part::parts]


_representatives = lru_cache(maxsize=8)(all_patterns)


def solve_chain(scenario: Scenario, tasks: Sequence[Task], new_solver: NewSolver = FixedGaitSolver) -> list[Solution]:
    """Solve a chain of neighbouring tasks; a row per task and pattern, in that order, screened ones included."""
    search = _Chain(scenario, new_solver)
    return [row for task in tasks for row in search.solve(task)]


class _Chain:
    """The solver of a scenario and what the last task of the chain came to."""

    def __init__(self, scenario: Scenario, new_solver: NewSolver) -> None:
        self._scenario = scenario
        self._solver = new_solver(transcribe(scenario), scenario.strategy.solve_time_limit)
        self._finer = None if scenario.strategy.part else FinerMeshes(scenario, new_solver)
        self._solved: dict[Pattern, Attempt] = {}
        self._failed: set[Pattern] = set()

    def solve(self, task: Task) -> list[Solution]:
        """The rows of one task; keeps what the next one can start from."""
        scenario = self._scenario
        incumbent = math.inf if scenario.strategy.incumbent is None else scenario.strategy.incumbent
        patterns = candidate_patterns(scenario, task)
        reasons = {pattern: ruled_out(scenario, pattern, task, incumbent) for pattern in patterns}
        attempts = {pattern: self._try(pattern, task) for pattern in patterns if reasons[pattern] is None}
        for pattern in leaders(scenario, task, attempts, RECHECKED_GAITS):
            attempts[pattern] += recheck(self._solver, pattern, task, attempts[pattern])
        self._solved = {pattern: best for pattern, tried in attempts.items() if (best := best_of(tried)) is not None}
        self._failed = attempts.keys() - self._solved.keys()
        rows = []
        for pattern in patterns:
            reason = reasons[pattern]
            if reason is None:
                rows.append(solution(scenario, task, pattern, attempts[pattern]))
            else:
                rows.append(unsolved(scenario, task, pattern, reason))
        return rows if self._finer is None else self._finer.resolved(task, rows)

    def _try(self, pattern: Pattern, task: Task) -> list[Attempt]:
        # A pattern that just failed at the neighbour is not worth random starts here.
        restarts = 0 if pattern in self._failed else self._scenario.strategy.restarts
        return until_feasible(self._solver, pattern, task, neighbouring(self._solved.get(pattern)), restarts)
