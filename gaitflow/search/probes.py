"""Probes: patterns of a task solved on a coarse mesh, in a third of the time, to leave out what is far from the best.

Patterns differ widely in cost (under J3 the median pattern costs a hundred times the best), so a coarse probe is enough
to leave a pattern out. A sound bound rules out patterns unsolved that must cost more than the best motion known.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, Symmetry, representative
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search.attempts import neighbouring, until_feasible
from gaitflow.search.bound import ruled_out
from gaitflow.search.moves import doubled, library, neighbours, repeated, standing
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, NewSolver

COARSENESS = 0.4  # share of the knots in a phase that a probe has, if that is at least LEAST_KNOTS
LEAST_KNOTS = 3
EXPANDED = 4  # best patterns whose moves are all tried
# A coarse cost over the best one, up to which a pattern may be the best: by Euler's rule a coarse mesh adds 0 to 44 %,
# by the others, with linear forces on graded knots, at most 7 %.
PROMISING_BY_EULER, PROMISING = 1.45, 1.25
LEAST_PROMISING, MOST_PROMISING = 4, 15  # patterns, so that the best one has a runner-up, and that it takes no time
FEW_PHASES = 5  # from here on the library is too large, and is searched with half as many phases first


@dataclass
class Explored:
    """What is known of one task's patterns on the coarse mesh; `reach` is the ratio of costs that is promising."""

    reach: float
    probes: dict[Pattern, Attempt] = field(default_factory=dict)
    reasons: dict[Pattern, str] = field(default_factory=dict)  # why others were not solved
    calls: dict[Pattern, list[Attempt]] = field(default_factory=dict)  # all that a probe took
    half_calls: list[Attempt] = field(default_factory=list)  # with half as many phases

    def ranked(self) -> list[Pattern]:
        """Probed patterns, feasible ones by cost, then the others by violation."""
        return sorted(self.probes, key=lambda pattern: (*_merit(self.probes[pattern]), pattern))

    def promising(self) -> list[Pattern]:
        """Those that may be the best on a finer mesh; where no probe was feasible, those that came nearest."""
        ranked = self.ranked()
        feasible = [pattern for pattern in ranked if self.probes[pattern].feasible]
        if not feasible:
            return ranked[:MOST_PROMISING]
        most = self.reach * self.probes[feasible[0]].cost
        near = sum(self.probes[pattern].cost <= most for pattern in feasible)
        return feasible[: min(max(near, LEAST_PROMISING), MOST_PROMISING)]


def _merit(probe: Attempt) -> tuple[int, float]:
    return (0, probe.cost) if probe.feasible else (1, probe.violation)


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


class Prober:
    """The coarse solver of a scenario, and the probes of the last task, from which those of the next one start."""

    def __init__(self, scenario: Scenario, new_solver: NewSolver = FixedGaitSolver) -> None:
        settings = scenario.transcription
        self.scenario = scenario
        self.solver = new_solver(transcribe(coarse(scenario)), scenario.strategy.solve_time_limit)
        self._half = None
        if settings.phases > FEW_PHASES and settings.phases % 2 == 0:
            self._half = Prober(halved(scenario), new_solver)
        self._reach = PROMISING_BY_EULER if settings.integrator == "euler" else PROMISING
        self._before = Explored(self._reach)

    def explore(
        self,
        task: Task,
        known: Iterable[Pattern],
        incumbent: float = math.inf,
        solve: Callable[[Pattern, Attempt], float] | None = None,
    ) -> Explored:
        """Probe what is known and the seeds, then the moves from the best few until none of those has a new move.

        `incumbent` is the cost of the best motion known. A probe that promises a much better one is handed to `solve`
        at once, which returns the pattern's cost on the scenario's mesh, infinite without a motion: the earlier a good
        motion is known, the more patterns the bound rules out.
        """
        explored, symmetry = Explored(self._reach), self.scenario.symmetry(task)
        budget, stances = self.scenario.strategy.budget, self.scenario.stances_per_leg
        least = incumbent

        def probe(patterns: Iterable[Pattern]) -> None:
            nonlocal least
            for pattern in patterns:
                if len(explored.probes) >= budget:
                    return
                if pattern in explored.probes or pattern in explored.reasons:
                    continue
                reason = ruled_out(self.scenario, pattern, task, least)
                if reason is not None:
                    explored.reasons[pattern] = reason
                    continue
                found = self._probe(task, pattern, explored)
                if solve is not None and found.feasible and found.cost * self._reach < least:
                    least = min(least, solve(pattern, found))

        probe(representatives([*known, *self._seeds(task, symmetry, explored, incumbent)], symmetry))
        expanded: set[Pattern] = set()
        while len(explored.probes) < budget:
            fresh = [pattern for pattern in explored.ranked()[:EXPANDED] if pattern not in expanded]
            if not fresh:
                break
            expanded.add(fresh[0])
            probe(neighbours(fresh[0], stances, symmetry))
        self._before = explored
        return explored

    def _probe(self, task: Task, pattern: Pattern, explored: Explored) -> Attempt:
        before = neighbouring(self._before.probes.get(pattern))
        explored.calls[pattern] = until_feasible(self.solver, pattern, task, before, restarts=0)
        explored.probes[pattern] = explored.calls[pattern][-1]
        return explored.probes[pattern]

    def _seeds(self, task: Task, symmetry: Symmetry, explored: Explored, incumbent: float) -> list[Pattern]:
        """Where the search begins: the gait library, or what half as many phases do best; and two strides a cycle."""
        legs, phases = len(self.scenario.robot.legs), self.scenario.transcription.phases
        others = list[Pattern]()
        if self.scenario.stances_per_leg is None:
            others.append(standing(legs, phases))
            if phases % 2 == 0:
                others += [repeated(pattern) for pattern in library(legs, phases // 2, symmetry)]
        if self._half is None:
            return [*library(legs, phases, symmetry), *others]
        found = self._half.explore(task, self._half._before.promising(), incumbent)
        explored.half_calls += [*found.half_calls, *(call for calls in found.calls.values() for call in calls)]
        return [*(doubled(pattern) for pattern in found.promising()), *others]


def representatives(patterns: Iterable[Pattern], symmetry: Symmetry) -> list[Pattern]:
    """The patterns' representatives, each once, in order."""
    return list(dict.fromkeys(representative(pattern, symmetry) for pattern in patterns))
