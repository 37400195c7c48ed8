"""A plan for one task: the likeliest gait that refines to a feasible motion."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from gaitflow.runtime.manifest import Gait
from gaitflow.runtime.refine import Attempt, Refiner
from gaitflow.trajectory import Trajectory


@dataclass(frozen=True)
class Plan(Trajectory):
    """A motion (SI units, see `Trajectory`) for a task, with how it was found.

    cost in the scenario's units; violation is the worst scaled constraint violation, found by `gaitflow.check` and not
    by the solver, and `feasible` means at most 1e-6. path: "first" for the likeliest gait, "next:<n>" when the n-th
    after it was the first to refine, "failed" when none of `tried` converged to a feasible motion: then the motion is
    the least infeasible one, and feasible all the same when only the solver's optimality was not reached.
    tried: each gait with its outcome, in order. iterations over all tried; time_ms is wall time of the whole call.
    """

    gait: str
    pattern: str
    probability: float
    in_domain: bool
    cost: float
    feasible: bool
    violation: float
    iterations: int
    path: str
    tried: tuple[tuple[str, str], ...]
    time_ms: float


def refine_ranked(
    refiner: Refiner, ranked: Sequence[tuple[int, Gait, float]], speed: float, cycle_duration: float, started: float
) -> Plan:
    """Refine the gaits (index, gait, probability) in order until one converges to a feasible motion.

    `started` is `time.perf_counter()` when the caller began.
    """
    attempts: list[Attempt] = []
    for index, _, _ in ranked:
        attempts.append(refiner.solve(index, speed, cycle_duration))
        if attempts[-1].refined:
            break
    best = min(range(len(attempts)), key=lambda n: (not attempts[n].refined, attempts[n].violation))
    attempt, (_, gait, probability) = attempts[best], ranked[best]
    return Plan(
        **vars(attempt.trajectory),
        gait=gait.name,
        pattern=gait.pattern,
        probability=probability,
        in_domain=True,
        cost=attempt.cost,
        feasible=attempt.feasible,
        violation=attempt.violation,
        iterations=sum(each.iterations for each in attempts),
        path="failed" if not attempt.refined else f"next:{best}" if best else "first",
        tried=tuple((each[1].name, _outcome(done)) for each, done in zip(ranked, attempts, strict=False)),
        time_ms=(time.perf_counter() - started) * 1e3,
    )


def _outcome(attempt: Attempt) -> str:
    if attempt.refined:
        return "solved"
    fault = "not converged" if attempt.feasible else f"infeasible: violation {attempt.violation:.1e}"
    return f"{fault} after {attempt.iterations} iterations ({attempt.solver_status})"
