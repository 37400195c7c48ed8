"""A plan for one task: the gait that is predicted to cost least, refined; the next one when that fails."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from gaitflow.runtime.manifest import Gait
from gaitflow.runtime.refine import Attempt, Candidate, Refiner
from gaitflow.trajectory import Trajectory


@dataclass(frozen=True)
class Plan(Trajectory):
    """A motion (SI units, see `Trajectory`) for a task, with how it was found.

    cost in the scenario's units; violation is the worst scaled constraint violation, found by `gaitflow.check` and not
    by the solver, and `feasible` means at most 1e-6. path: "fast" when the first gait was refined by Newton steps from
    its prediction, "fallback" when IPOPT had to, "next:<n>" when the n-th gait after it was the first to refine,
    "failed" when none of `tried` converged to a feasible motion: then the motion is the least infeasible one, and
    feasible all the same when only optimality was not reached. tried: each gait with its outcome, in order.
    iterations over all tried. distance: to the nearest training task, in steps of the map's grid. time_ms is wall time
    of the whole call; select_ms of choosing the gaits, predict_ms and refine_ms of their starts and solves.
    """

    gait: str
    pattern: str
    probability: float
    in_domain: bool
    distance: float
    cost: float
    feasible: bool
    violation: float
    iterations: int
    path: str
    tried: tuple[tuple[str, str], ...]
    select_ms: float
    predict_ms: float
    refine_ms: float
    time_ms: float


@dataclass(frozen=True)
class Asked:
    """The task (m/s, s) of a plan, what the map said of it, and `time.perf_counter()` when the call began."""

    speed: float
    cycle_duration: float
    in_domain: bool
    distance: float
    started: float


def refine_ranked(refiner: Refiner, ranked: Sequence[tuple[Candidate, Gait, float]], asked: Asked) -> Plan:
    """Refine the gaits (candidate, gait, probability) in order until one converges to a feasible motion."""
    selected = time.perf_counter()
    attempts: list[Attempt] = []
    for candidate, _, _ in ranked:
        attempts.append(refiner.solve(candidate, asked.speed, asked.cycle_duration))
        if attempts[-1].refined:
            break
    best = min(range(len(attempts)), key=lambda n: (not attempts[n].refined, attempts[n].violation))
    attempt, (_, gait, probability) = attempts[best], ranked[best]
    return Plan(
        **vars(attempt.trajectory),
        gait=gait.name,
        pattern=attempt.pattern,
        probability=probability,
        in_domain=asked.in_domain,
        distance=asked.distance,
        cost=attempt.cost,
        feasible=attempt.feasible,
        violation=attempt.violation,
        iterations=sum(each.iterations for each in attempts),
        path="failed" if not attempt.refined else f"next:{best}" if best else attempt.method,
        tried=tuple((each[1].name, _outcome(done)) for each, done in zip(ranked, attempts, strict=False)),
        select_ms=(selected - asked.started) * 1e3,
        predict_ms=sum(each.predict_ms for each in attempts),
        refine_ms=sum(each.refine_ms for each in attempts),
        time_ms=(time.perf_counter() - asked.started) * 1e3,
    )


def _outcome(attempt: Attempt) -> str:
    if attempt.refined:
        return f"solved, {attempt.method}"
    fault = "not converged" if attempt.feasible else f"infeasible: violation {attempt.violation:.1e}"
    return f"{fault} after {attempt.iterations} iterations ({attempt.solver_status})"
