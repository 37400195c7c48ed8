"""One pattern at one task, tried from several starts, since every solve is only a local optimum; and its row."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task
from gaitflow.search import starts as guess
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

SAME_COST = 1e-6  # relative; a recheck replaces a solution only when it is better by more


def best_of(attempts: Sequence[Attempt]) -> Attempt | None:
    """The cheapest feasible attempt; of equals within SAME_COST the earliest."""
    best: Attempt | None = None
    for attempt in attempts:
        if attempt.feasible and (best is None or attempt.cost < best.cost - SAME_COST * abs(best.cost)):
            best = attempt
    return best


def seed_of(*parts: object) -> int:
    """A seed that depends on the parts alone, so that a unit solves the same wherever it runs."""
    return int.from_bytes(hashlib.sha256(repr(parts).encode()).digest()[:8], "big")


def until_feasible(
    solver: FixedGaitSolver, pattern: Pattern, task: Task, neighbour: Attempt | None, restarts: int
) -> list[Attempt]:
    """Attempts up to the first feasible one: from the neighbour's solution, nominal, from `restarts` random points."""
    attempts: list[Attempt] = []
    for start in _starts(solver, pattern, task, neighbour, restarts):
        # Where the solver ended at a point of local infeasibility, a random start never helped: see DESIGN.md.
        if start.name.startswith("random") and not any(attempt.gave_up for attempt in attempts):
            break
        attempts.append(solver.solve(pattern, task.speed, task.cycle_duration, start))
        if attempts[-1].feasible:
            break
    return attempts


def _starts(
    solver: FixedGaitSolver, pattern: Pattern, task: Task, neighbour: Attempt | None, restarts: int
) -> Iterator[Start]:
    if neighbour is not None:
        yield Start("neighbour", neighbour.w, neighbour.multipliers)
    problem = solver.problem
    robot, layout = problem.scenario.robot, problem.layout
    yield Start("nominal", guess.nominal(robot, layout, task.speed, task.cycle_duration))
    for number in range(restarts):
        yield _random_start(solver, pattern, task, number)


def _random_start(solver: FixedGaitSolver, pattern: Pattern, task: Task, number: int) -> Start:
    problem = solver.problem
    seed = seed_of(problem.scenario.strategy.seed, pattern.text, task.speed, task.cycle_duration, number)
    w = guess.random(
        problem.scenario.robot, problem.layout, task.speed, task.cycle_duration, np.random.default_rng(seed)
    )
    return Start(f"random-{number}", w)


def leaders(scenario: Scenario, attempts: Mapping[Pattern, Sequence[Attempt]], gaits: int) -> list[Pattern]:
    """The best pattern of each of the cheapest `gaits` gaits."""
    best = {pattern: found.cost for pattern, tried in attempts.items() if (found := best_of(tried)) is not None}
    first: dict[str, Pattern] = {}
    for pattern in sorted(best, key=lambda pattern: (best[pattern], pattern)):
        first.setdefault(_gait_text(scenario, pattern), pattern)
    return list(first.values())[:gaits]


def recheck(solver: FixedGaitSolver, pattern: Pattern, task: Task, done: Sequence[Attempt]) -> list[Attempt]:
    """Attempts in other basins: from the nominal start if it was not tried, and from one random start."""
    tried = {attempt.start for attempt in done}
    problem = solver.problem
    starts = [
        Start("nominal", guess.nominal(problem.scenario.robot, problem.layout, task.speed, task.cycle_duration)),
        _random_start(solver, pattern, task, 0),
    ]
    return [
        solver.solve(pattern, task.speed, task.cycle_duration, start) for start in starts if start.name not in tried
    ]


def solution(scenario: Scenario, task: Task, pattern: Pattern, attempts: Sequence[Attempt]) -> Solution:
    """The dataset row of one pattern at one task from all that was tried."""
    best = best_of(attempts)
    kept = best or min(attempts, key=lambda attempt: attempt.violation)
    if best is not None:
        status = "solved"
    else:
        status = "failed" if all(attempt.gave_up for attempt in attempts) else "infeasible"
    return Solution(
        speed=task.speed,
        cycle_duration=task.cycle_duration,
        split=task.split,
        pattern=pattern.text,
        gait=_gait_text(scenario, pattern),
        strategy=scenario.strategy.name,
        start=kept.start,
        seed=scenario.strategy.seed,
        status=status,  # type: ignore[arg-type]
        solver_status=kept.solver_status,
        cost=best.cost if best else float("nan"),
        violation=kept.violation,
        iterations=sum(attempt.iterations for attempt in attempts),
        solves=len(attempts),
        wall_s=sum(attempt.wall_s for attempt in attempts),
        cpu_s=sum(attempt.cpu_s for attempt in attempts),
        trajectory=best.trajectory if best else None,
        multipliers=best.multipliers if best else None,
    )


def screened(scenario: Scenario, task: Task, pattern: Pattern, reason: str) -> Solution:
    """The dataset row of a pattern that a necessary condition rules out."""
    nan = float("nan")
    return Solution(
        task.speed, task.cycle_duration, task.split, pattern.text, _gait_text(scenario, pattern),
        scenario.strategy.name, "", scenario.strategy.seed, "screened", reason, nan, nan, 0, 0, 0.0, 0.0,
    )  # fmt: skip


def _gait_text(scenario: Scenario, pattern: Pattern) -> str:
    robot = scenario.robot
    return gait_of(pattern, robot.mirror_permutation if robot.mirror else None).text
