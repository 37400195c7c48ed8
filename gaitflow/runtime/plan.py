"""A plan for one task: the gait that is predicted to cost least, refined; the next one when that fails."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Trajectory
from gaitflow.runtime.manifest import Gait
from gaitflow.runtime.refine import FAST, Attempt, Candidate, Refiner

LEAST_SAVING = 1e-3  # relative cost that another gait must promise to save
OFF = 1e-2  # relative error of a predicted cost, above which the other gaits' may be as far off


@dataclass(frozen=True)
class Plan(Trajectory):
    """A motion (SI units, see `Trajectory`) for a task, with how it was found.

    task: speed [m/s], cycle_duration [s] and the map's other ranged axes. cost in the scenario's units; violation is
    the worst scaled constraint violation, found by `gaitflow.core.check` and not by the solver; `feasible` means at
    most 1e-6. path: "fast" when the first gait was refined by Newton steps from its prediction, "fallback" when IPOPT
    had to, "next:<n>" when the n-th gait after it was the first to refine,
    "cheaper:<n>" when that one was refined, too, and costs less than the first, which came out dearer than predicted,
    "failed" when none of `tried` converged to a feasible motion: then the motion is the least infeasible one, and
    feasible all the same when only optimality was not reached. tried: each gait with its outcome, in order.
    iterations over all tried. distance: to the nearest training task, in steps of the map's grid. time_ms is wall time
    of the whole call; select_ms of choosing the gaits, predict_ms and refine_ms of their starts and solves.
    """

    task: Mapping[str, float]
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
    """The task of a plan, its values by axis, what the map said of it, and `perf_counter()` when the call began."""

    task: Task
    values: Mapping[str, float]
    in_domain: bool
    distance: float
    started: float


def refine_ranked(refiner: Refiner, ranked: Sequence[tuple[Candidate, Gait, float]], asked: Asked) -> Plan:
    """Refine the gaits (candidate, gait, probability) in order until one converges to a feasible motion.

    Where another one may cost less than that came to, it is refined as well, and the cheaper one taken: before a cliff
    of the cost, predictions are far off. So it is where the first one's prediction was off by more than what another
    one was predicted to cost beyond it.
    IPOPT is asked only when the fast method has failed for all of them: where the first gait has no motion, as beyond
    its longest stride, it takes a second to find that out, and a planner cannot wait for it.
    """
    selected = time.perf_counter()
    attempts = list(_attempts(refiner, [candidate for candidate, _, _ in ranked], asked))
    best, attempt = min(attempts, key=_merit)
    _, gait, probability = ranked[best]
    last = {place: done for place, done in attempts}
    first = next((place for place, done in attempts if done.refined), best)
    return Plan(
        **vars(attempt.trajectory),
        task=asked.values,
        gait=gait.name,
        pattern=attempt.pattern,
        probability=probability,
        in_domain=asked.in_domain,
        distance=asked.distance,
        cost=attempt.cost,
        feasible=attempt.feasible,
        violation=attempt.violation,
        iterations=sum(done.iterations for _, done in attempts),
        path=_path(attempt, best, first),
        tried=tuple((ranked[place][1].name, _outcome(last[place])) for place in sorted(last)),
        select_ms=(selected - asked.started) * 1e3,
        predict_ms=sum(done.predict_ms for _, done in attempts),
        refine_ms=sum(done.refine_ms for _, done in attempts),
        time_ms=(time.perf_counter() - asked.started) * 1e3,
    )


def _attempts(refiner: Refiner, candidates: Sequence[Candidate], asked: Asked) -> Iterator[tuple[int, Attempt]]:
    for refine, place in itertools.product((refiner.fast, refiner.fallback), range(len(candidates))):
        attempt = refine(candidates[place], asked.task)
        yield place, attempt
        if attempt.refined:
            break
    rivals = range(place + 1, len(candidates)) if attempt.refined and attempt.method == FAST else ()
    least = {rival: refiner.least(candidates[rival], asked.task) for rival in rivals}
    if least and min(least.values()) < _worth_a_look(attempt):
        rival = min(rivals, key=least.__getitem__)
        yield rival, refiner.fast(candidates[rival], asked.task, most=1)


def _worth_a_look(attempt: Attempt) -> float:
    """The cost below which another gait's promise is looked at: where this one's was off, the other may be as well."""
    off = abs(attempt.cost / attempt.expected - 1) if attempt.expected > 0 else 0.0
    return attempt.cost * (1 - LEAST_SAVING) * (1 + (off if OFF < off < math.inf else 0.0))


def _merit(each: tuple[int, Attempt]) -> tuple[bool, float]:
    """Least first: refined motions by cost, others by violation."""
    _, attempt = each
    return (False, attempt.cost) if attempt.refined else (True, attempt.violation)


def _path(attempt: Attempt, best: int, first: int) -> str:
    """`first` is the place of the first gait that refined, `best` of the one taken, by this attempt."""
    if not attempt.refined:
        return "failed"
    if best != first:
        return f"cheaper:{best}"
    return f"next:{best}" if best else attempt.method


def _outcome(attempt: Attempt) -> str:
    if attempt.refined:
        return f"solved, {attempt.method}"
    fault = "not converged" if attempt.feasible else f"infeasible: violation {attempt.violation:.1e}"
    return f"{fault} after {attempt.iterations} iterations ({attempt.solver_status})"
