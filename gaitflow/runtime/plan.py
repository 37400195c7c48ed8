"""A plan for one task: the gait that is predicted to cost least, refined; the next one when that fails."""

from __future__ import annotations

import itertools
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
    """Refine the gaits (candidate, gait, probability) in order until one converges to a feasible motion.

    IPOPT is asked only when the fast method has failed for all of them: where the first gait has no motion, as beyond
    its longest stride, it takes a second to find that out, and a planner cannot wait for it.
    """
    selected = time.perf_counter()
    attempts: list[tuple[int, Attempt]] = []
    for refine, place in itertools.product((refiner.fast, refiner.fallback), range(len(ranked))):
        attempts.append((place, refine(ranked[place][0], asked.speed, asked.cycle_duration)))
        if attempts[-1][1].refined:
            break
    best, attempt = min(attempts, key=lambda each: (not each[1].refined, each[1].violation))
    _, gait, probability = ranked[best]
    last = {place: done for place, done in attempts}
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
        iterations=sum(done.iterations for _, done in attempts),
        path="failed" if not attempt.refined else f"next:{best}" if best else attempt.method,
        tried=tuple((ranked[place][1].name, _outcome(last[place])) for place in sorted(last)),
        select_ms=(selected - asked.started) * 1e3,
        predict_ms=sum(done.predict_ms for _, done in attempts),
        refine_ms=sum(done.refine_ms for _, done in attempts),
        time_ms=(time.perf_counter() - asked.started) * 1e3,
    )


def _outcome(attempt: Attempt) -> str:
    if attempt.refined:
        return f"solved, {attempt.method}"
    fault = "not converged" if attempt.feasible else f"infeasible: violation {attempt.violation:.1e}"
    return f"{fault} after {attempt.iterations} iterations ({attempt.solver_status})"
