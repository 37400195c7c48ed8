"""Guided search, ours: where patterns are too many to solve them all, go from good patterns to better ones.

One task: patterns are *probed*, solved on a coarse mesh in a third of the time, best first: the leaders of the
neighbour task, the gait library, then the local moves from the best few until those have no unprobed move left or the
budget is spent. A sound bound rules out, unsolved, what must cost more than the best motion known. The promising few
are then solved on the scenario's own mesh, and the best of them again from other starts.

Costs fall steeply in pattern space (under J3 the median pattern costs a hundred times the best), which is what
makes a coarse probe enough to leave a pattern out. DESIGN.md tells how the search was checked against all patterns.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, Symmetry, representative
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search.attempts import best_of, leaders, recheck, until_feasible
from gaitflow.search.bound import ruled_out
from gaitflow.search.exhaustive import RECHECKED_GAITS
from gaitflow.search.moves import doubled, library, neighbours, repeated, standing
from gaitflow.search.refine import Refinement
from gaitflow.search.rows import solution, unsolved
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver

COARSENESS = 0.4  # share of the knots in a phase that a probe has, if that is at least LEAST_KNOTS
LEAST_KNOTS = 3
EXPANDED = 4  # best patterns whose moves are all tried
FINALISTS = 15  # patterns solved on the scenario's mesh
PROMISING = 1.45  # a finalist's coarse cost over the best one: a coarse mesh adds 0 to 44 %, not the same to all
FEW_PHASES = 5  # from here on the library is too large, and is searched with half as many phases first

Probes = dict[Pattern, Attempt]


def solve_guided(scenario: Scenario, tasks: Sequence[Task]) -> list[Solution]:
    """Search a chain of neighbouring tasks; a row per task and pattern met, by task, then by pattern.

    Status `screened`: ruled out, the reason beside it; `probed`: solved on the coarse mesh only; others were solved on
    the scenario's.
    """
    search = _Search(scenario)
    rows: list[Solution] = []
    for task in tasks:
        rows += search.solve(task)
    return rows


def coarse(scenario: Scenario) -> Scenario:
    """The scenario on the mesh of the probes."""
    knots = scenario.transcription.knots_per_phase
    return _transcribed(scenario, knots_per_phase=min(knots, max(LEAST_KNOTS, round(COARSENESS * knots))))


def halved(scenario: Scenario) -> Scenario:
    """The scenario with half the phases and the same mesh: its motions are motions of the scenario, too."""
    settings = scenario.transcription
    return _transcribed(
        scenario,
        phases=settings.phases // 2,
        knots_per_phase=min(50, 2 * settings.knots_per_phase),
        min_phase_fraction=min(2 * settings.min_phase_fraction, 2 / settings.phases),
    )


def _transcribed(scenario: Scenario, **changes: float) -> Scenario:
    return scenario.model_copy(update={"transcription": scenario.transcription.model_copy(update=changes)})


@dataclass
class _Explored:
    """What is known of one task's patterns on the coarse mesh."""

    probes: Probes = field(default_factory=dict)
    reasons: dict[Pattern, str] = field(default_factory=dict)
    calls: dict[Pattern, list[Attempt]] = field(default_factory=dict)  # all that a probe took
    before: list[Attempt] = field(default_factory=list)  # calls with half as many phases

    def ranked(self) -> list[Pattern]:
        """Probed patterns, feasible ones by cost, then the others by violation."""
        return sorted(self.probes, key=lambda pattern: (*_merit(self.probes[pattern]), pattern))


def _merit(probe: Attempt) -> tuple[int, float]:
    return (0, probe.cost) if probe.feasible else (1, probe.violation)


class _Search:
    """The solvers of a scenario and what the last task taught."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        settings, limit = scenario.transcription, scenario.strategy.solve_time_limit
        self.fine = FixedGaitSolver(transcribe(scenario), limit)
        self.coarse = FixedGaitSolver(transcribe(coarse(scenario)), limit)
        self.refinement = Refinement(scenario)
        self.half = None
        if settings.phases > FEW_PHASES and settings.phases % 2 == 0:
            self.half = _Search(halved(scenario))
        self.probes: Probes = {}
        self.solved: Probes = {}

    def solve(self, task: Task) -> list[Solution]:
        """The rows of one task; keeps what the next one can start from."""
        explored, attempts = _Explored(), dict[Pattern, list[Attempt]]()
        known = self._cheapest_before(task)
        for pattern in known[:1]:
            self._finish(task, pattern, attempts)
        seeds = [*known, *self._seeds(task, explored)]
        if _incumbent(attempts) == math.inf:
            self._probe(task, seeds, explored, math.inf)
            for pattern in explored.ranked()[:1]:
                self._finish(task, pattern, attempts)
        self._explore(task, seeds, explored, _incumbent(attempts))
        for pattern in self._finalists(explored):
            self._finish(task, pattern, attempts)
        for pattern in leaders(self.scenario, task, attempts, RECHECKED_GAITS):
            attempts[pattern] += recheck(self.fine, pattern, task, attempts[pattern])
        self.probes = explored.probes
        self.solved = {pattern: best for pattern, tried in attempts.items() if (best := best_of(tried)) is not None}
        return self.refinement.refined(task, self._rows(task, explored, attempts))

    def _cheapest_before(self, task: Task) -> list[Pattern]:
        """What was solved at the last task, cheapest first."""
        symmetry = self.scenario.symmetry(task)
        ordered = sorted(self.solved, key=lambda pattern: (self.solved[pattern].cost, pattern))
        return _representatives(ordered, symmetry)

    def _seeds(self, task: Task, explored: _Explored) -> list[Pattern]:
        """Where the search begins: the gait library, or what half as many phases do best; and two strides a cycle."""
        phases, symmetry = self.scenario.transcription.phases, self.scenario.symmetry(task)
        others = list[Pattern]()
        if self.scenario.stances_per_leg is None:
            others.append(standing(len(self.scenario.robot.legs), phases))
            if phases % 2 == 0:
                others += [repeated(pattern) for pattern in self._library(phases // 2, symmetry)]
        if self.half is None:
            return _representatives([*self._library(phases, symmetry), *others], symmetry)
        found = _Explored()
        seeds = [*self.half._known(), *self.half._seeds(task, found)]
        self.half._explore(task, seeds, found, math.inf)
        self.half.probes = found.probes
        explored.before += [*found.before, *(call for calls in found.calls.values() for call in calls)]
        best = [doubled(pattern) for pattern in self.half._finalists(found)]
        return _representatives([*best, *others], symmetry)

    def _library(self, phases: int, symmetry: Symmetry) -> tuple[Pattern, ...]:
        return library(len(self.scenario.robot.legs), phases, symmetry)

    def _known(self) -> list[Pattern]:
        """The promising patterns of the last task."""
        return self._finalists(_Explored(self.probes))

    def _explore(self, task: Task, seeds: Iterable[Pattern], explored: _Explored, incumbent: float) -> None:
        """Probe the seeds, then the moves from the best few until none of those has a new move."""
        self._probe(task, seeds, explored, incumbent)
        expanded: set[Pattern] = set()
        while len(explored.probes) < self.scenario.strategy.budget:
            fresh = [pattern for pattern in explored.ranked()[:EXPANDED] if pattern not in expanded]
            if not fresh:
                break
            expanded.add(fresh[0])
            moves = neighbours(fresh[0], self.scenario.stances_per_leg, self.scenario.symmetry(task))
            self._probe(task, moves, explored, incumbent)

    def _probe(self, task: Task, patterns: Iterable[Pattern], explored: _Explored, incumbent: float) -> None:
        for pattern in patterns:
            if pattern in explored.probes or pattern in explored.reasons:
                continue
            if len(explored.probes) >= self.scenario.strategy.budget:
                return
            reason = ruled_out(self.scenario, pattern, task, incumbent)
            if reason is not None:
                explored.reasons[pattern] = reason
                continue
            before = self.probes.get(pattern)
            neighbour = before if before is not None and before.feasible else None
            explored.calls[pattern] = until_feasible(self.coarse, pattern, task, neighbour, restarts=0)
            explored.probes[pattern] = explored.calls[pattern][-1]

    def _finalists(self, explored: _Explored) -> list[Pattern]:
        """The patterns worth a solve on the full mesh; where no probe was feasible, those that came nearest."""
        ranked = explored.ranked()
        feasible = [pattern for pattern in ranked if explored.probes[pattern].feasible]
        if not feasible:
            return ranked[:FINALISTS]
        best = explored.probes[feasible[0]].cost
        return [pattern for pattern in feasible if explored.probes[pattern].cost <= PROMISING * best][:FINALISTS]

    def _finish(self, task: Task, pattern: Pattern, attempts: dict[Pattern, list[Attempt]]) -> None:
        """Solve a pattern on the scenario's mesh, once."""
        if pattern not in attempts:
            restarts = self.scenario.strategy.restarts
            attempts[pattern] = until_feasible(self.fine, pattern, task, self.solved.get(pattern), restarts)

    def _rows(self, task: Task, explored: _Explored, attempts: dict[Pattern, list[Attempt]]) -> list[Solution]:
        rows = []
        unowned = explored.before  # counted with the first row that was solved at all
        for pattern in sorted({*explored.probes, *explored.reasons, *attempts}):
            probe = explored.probes.get(pattern)
            if pattern in attempts:
                row = solution(self.scenario, task, pattern, attempts[pattern])
            elif probe is not None:
                row = unsolved(self.scenario, task, pattern, _verdict(probe), "probed", probe.start)
            else:
                row = unsolved(self.scenario, task, pattern, explored.reasons[pattern])
            calls = explored.calls.get(pattern, [])
            if calls:
                calls, unowned = [*calls, *unowned], []
            rows.append(_with_effort(row, calls))
        return rows


def _representatives(patterns: Iterable[Pattern], symmetry: Symmetry) -> list[Pattern]:
    """The patterns' representatives, each once, in order."""
    return list(dict.fromkeys(representative(pattern, symmetry) for pattern in patterns))


def _incumbent(attempts: dict[Pattern, list[Attempt]]) -> float:
    costs = [best.cost for tried in attempts.values() if (best := best_of(tried)) is not None]
    return min(costs, default=math.inf)


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
