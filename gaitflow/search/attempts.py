"""One pattern at one task, tried from several starts, since every solve is only a local optimum."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

SAME_COST = 1e-6  # relative; a recheck replaces a solution only when it is better by more


def best_of(attempts: Sequence[Attempt]) -> Attempt | None:
    """The cheapest feasible attempt; of equals within SAME_COST the earliest."""
    best: Attempt | None = None
    for attempt in attempts:
        if attempt.feasible and (best is None or attempt.cost < best.cost - SAME_COST * abs(best.cost)):
            best = attempt
    return best


def neighbouring(solved: Attempt | None) -> Start | None:
    """The start, primal and dual, from a pattern's solution at the task before; None without a feasible one."""
    return Start("neighbour", solved.w, solved.multipliers) if solved is not None and solved.feasible else None


def until_feasible(
    solver: FixedGaitSolver, pattern: Pattern, task: Task, first: Start | None, restarts: int
) -> list[Attempt]:
    """Attempts up to the first feasible one: from the start given, nominal, from `restarts` random points.

    Random starts are taken while the last one led to no verdict: where the solver found that rows cannot be met, a
    random start never helped, see DESIGN.md.
    """
    attempts: list[Attempt] = []
    for start in _starts(solver, pattern, task, first, restarts):
        if start.name.startswith("random") and not attempts[-1].gave_up:
            break
        attempts.append(solver.solve(pattern, task, start))
        if attempts[-1].feasible:
            break
    return attempts


def leaders(scenario: Scenario, task: Task, attempts: Mapping[Pattern, Sequence[Attempt]], gaits: int) -> list[Pattern]:
    """The best pattern of each of the cheapest `gaits` gaits."""
    symmetry = scenario.symmetry(task)
    best = {pattern: found.cost for pattern, tried in attempts.items() if (found := best_of(tried)) is not None}
    first: dict[Pattern, Pattern] = {}
    for pattern in sorted(best, key=lambda pattern: (best[pattern], pattern)):
        first.setdefault(gait_of(pattern, symmetry), pattern)
    return list(first.values())[:gaits]


def recheck(solver: FixedGaitSolver, pattern: Pattern, task: Task, done: Sequence[Attempt]) -> list[Attempt]:
    """An attempt in another basin: from the nominal start, or where that was tried from a random one."""
    tried = {attempt.start for attempt in done}
    chosen = [_nominal(solver, task), _random(solver, pattern, task, 0)]
    untried = [start for start in chosen if start.name not in tried]
    return [solver.solve(pattern, task, start) for start in untried[:1]]


def _starts(
    solver: FixedGaitSolver, pattern: Pattern, task: Task, first: Start | None, restarts: int
) -> Iterator[Start]:
    if first is not None:
        yield first
    yield _nominal(solver, task)
    for number in range(restarts):
        yield _random(solver, pattern, task, number)


def _nominal(solver: FixedGaitSolver, task: Task) -> Start:
    problem = solver.problem
    return Start("nominal", starts.nominal(problem.scenario.robot, problem.layout, task))


def _random(solver: FixedGaitSolver, pattern: Pattern, task: Task, number: int) -> Start:
    problem = solver.problem
    seed = starts.seed_of(problem.scenario.strategy.seed, pattern.text, *task.values, number)
    drawn = starts.random(problem.scenario.robot, problem.layout, task, np.random.default_rng(seed))
    return Start(f"random-{number}", drawn)
