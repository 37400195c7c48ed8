"""The dataset row of a pattern at a task: from all its attempts, or with the reason why there were none."""

from __future__ import annotations

from collections.abc import Sequence

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task import Task
from gaitflow.search.attempts import best_of
from gaitflow.search.solution import NAN, Solution, Status
from gaitflow.solvers.fixed_gait import Attempt


def solution(scenario: Scenario, task: Task, pattern: Pattern, attempts: Sequence[Attempt]) -> Solution:
    """The row of one pattern at one task from all that was tried, one attempt at least."""
    best = best_of(attempts)
    kept = best or min(attempts, key=lambda attempt: attempt.violation)
    status: Status = "solved"
    if best is None:
        status = "failed" if all(attempt.gave_up for attempt in attempts) else "infeasible"
    return Solution(
        task=task,
        pattern=pattern.text,
        gait=gait_of(pattern, scenario.symmetry(task)).text,
        strategy=scenario.strategy.name,
        start=kept.start,
        seed=scenario.strategy.seed,
        status=status,
        solver_status=kept.solver_status,
        cost=best.cost if best else NAN,
        violation=kept.violation,
        iterations=sum(attempt.iterations for attempt in attempts),
        solves=len(attempts),
        wall_s=sum(attempt.wall_s for attempt in attempts),
        cpu_s=sum(attempt.cpu_s for attempt in attempts),
        trajectory=best.trajectory if best else None,
        multipliers=best.multipliers if best else None,
    )


def unsolved(
    scenario: Scenario, task: Task, pattern: Pattern, reason: str, status: Status = "screened", start: str = ""
) -> Solution:
    """The row of a pattern that was not solved on the scenario's mesh, and why."""
    return Solution(
        task=task,
        pattern=pattern.text,
        gait=gait_of(pattern, scenario.symmetry(task)).text,
        strategy=scenario.strategy.name,
        start=start,
        seed=scenario.strategy.seed,
        status=status,
        solver_status=reason,
    )
