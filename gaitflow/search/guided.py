"""Guided search, ours: where patterns are too many to solve them all, go from good patterns to better ones.

One task: patterns are *probed*, solved on a coarse mesh, best first: the leaders of the neighbour task, the gait
library, then the local moves from the best few until those have no unprobed move left or the budget is spent. The
promising few are then solved on the scenario's own mesh, and the best of them again from other starts. DESIGN.md tells
how the search was checked against all patterns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search.attempts import best_of, leaders, neighbouring, recheck, until_feasible
from gaitflow.search.exhaustive import RECHECKED_GAITS
from gaitflow.search.probes import Explored, Prober, representatives
from gaitflow.search.resolve import FinerMeshes, on_other_mesh
from gaitflow.search.rows import solution, unsolved
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, NewSolver


def solve_guided(scenario: Scenario, tasks: Sequence[Task], new_solver: NewSolver = FixedGaitSolver) -> list[Solution]:
    """Search a chain of neighbouring tasks; a row per task and pattern met, by task, then by pattern.

    Status `screened`: ruled out, the reason beside it; `probed`: solved on the coarse mesh only; others were solved on
    the scenario's.
    """
    search = _Search(scenario, new_solver)
    return [row for task in tasks for row in search.solve(task)]


class _Search:
    """The solvers of a scenario and what the last task of the chain came to."""

    def __init__(self, scenario: Scenario, new_solver: NewSolver) -> None:
        self._scenario = scenario
        self._solver = new_solver(transcribe(scenario), scenario.strategy.solve_time_limit)
        self._prober = Prober(scenario, new_solver)
        self._finer = FinerMeshes(scenario, new_solver)
        self._solved: dict[Pattern, Attempt] = {}

    def solve(self, task: Task) -> list[Solution]:
        """The rows of one task; keeps what the next one can start from."""
        attempts: dict[Pattern, list[Attempt]] = {}

        def finish(pattern: Pattern, probe: Attempt | None) -> float:
            """The pattern's cost on the scenario's mesh, where it is solved once; infinite without a motion."""
            if pattern not in attempts:
                attempts[pattern] = self._try(task, pattern, probe)
            best = best_of(attempts[pattern])
            return math.inf if best is None else best.cost

        known = self._cheapest_before(task)
        incumbent = min((finish(pattern, None) for pattern in known[:1]), default=math.inf)
        explored = self._prober.explore(task, known, incumbent, finish)
        for pattern in explored.promising():
            finish(pattern, explored.probes[pattern])
        for pattern in leaders(self._scenario, task, attempts, RECHECKED_GAITS):
            attempts[pattern] += recheck(self._solver, pattern, task, attempts[pattern])
        self._solved = {pattern: best for pattern, tried in attempts.items() if (best := best_of(tried)) is not None}
        return self._finer.resolved(task, self._rows(task, explored, attempts))

    def _cheapest_before(self, task: Task) -> list[Pattern]:
        """What was solved at the last task, cheapest first."""
        ordered = sorted(self._solved, key=lambda pattern: (self._solved[pattern].cost, pattern))
        return representatives(ordered, self._scenario.symmetry(task))

    def _try(self, task: Task, pattern: Pattern, probe: Attempt | None) -> list[Attempt]:
        """Solve a pattern on the scenario's mesh: from its neighbour's solution, else from its probe."""
        start = neighbouring(self._solved.get(pattern))
        if start is None and probe is not None and probe.feasible:
            given = self._prober.solver.problem.layout
            start = on_other_mesh("probe", probe.trajectory, given, self._solver.problem, task)
        return until_feasible(self._solver, pattern, task, start, self._scenario.strategy.restarts)

    def _rows(self, task: Task, explored: Explored, attempts: Mapping[Pattern, Sequence[Attempt]]) -> list[Solution]:
        rows = []
        unowned = explored.half_calls  # counted with the first row that was solved at all
        for pattern in sorted({*explored.probes, *explored.reasons, *attempts}):
            probe = explored.probes.get(pattern)
            if pattern in attempts:
                row = solution(self._scenario, task, pattern, attempts[pattern])
            elif probe is not None:
                row = unsolved(self._scenario, task, pattern, _verdict(probe), "probed", probe.start)
            else:
                row = unsolved(self._scenario, task, pattern, explored.reasons[pattern])
            calls = explored.calls.get(pattern, [])
            if calls:
                calls, unowned = [*calls, *unowned], []
            rows.append(_with_effort(row, calls))
        return rows


def _verdict(probe: Attempt) -> str:
    if probe.feasible:
        return f"costs {probe.cost:.6g} on the coarse mesh, too much to be promising"
    return f"no motion found on the coarse mesh: {probe.solver_status}"


def _with_effort(row: Solution, calls: Sequence[Attempt]) -> Solution:
    return replace(
        row,
        iterations=row.iterations + sum(call.iterations for call in calls),
        solves=row.solves + len(calls),
        wall_s=row.wall_s + sum(call.wall_s for call in calls),
        cpu_s=row.cpu_s + sum(call.cpu_s for call in calls),
    )
