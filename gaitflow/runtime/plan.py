"""A plan for one task: the gait that is predicted to cost least, refined; the next one when that fails.

A gait may have several patterns. Each has a prediction of its own and is a candidate.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Any, Literal

from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Trajectory
from gaitflow.motion import Frames, Motion, Point
from gaitflow.motion.motion import SWING_APEX
from gaitflow.runtime.attempt import Attempt, Candidate, GaitRefiner
from gaitflow.runtime.left_out import ChosenValue
from gaitflow.runtime.manifest import Gait
from gaitflow.runtime.rivals import LEAST_SAVING, effort_for, likely, tried_below, unlikely

TOP = 5  # gaits that a plan tries unless it is told otherwise


@dataclass(frozen=True)
class Plan(Trajectory):
    """A motion (SI units, see `Trajectory`) for a task, with how it was found.

    - task: speed [m/s], cycle_duration [s] and the map's other ranged axes. scenario: the map's, as JSON data.
    - cost: in the scenario's units. violation: the worst scaled constraint violation, found by `gaitflow.core.check`
      and not by the solver. feasible: violation is at most 1e-6.
    - path: "fast" when Newton steps refined the first gait from its prediction; "next:<n>" when the n-th gait after it
      was the first that could be refined; "cheaper:<n>" when that gait was refined after another one and costs less;
      "fallback" when only IPOPT found a motion; "failed" when none of `tried` converged to a feasible motion. Then the
      motion is the least infeasible one; it may be feasible when only optimality was not reached.
    - tried: gaits with their outcomes, in order, a gait once for each of its patterns that was tried. iterations: of
      all tried.
    - distance: to the nearest task that the map was trained on, in steps of its grid.
    - time_ms: wall time of the whole call; select_ms of choosing the gaits, predict_ms and refine_ms of their starts
      and solves.
    - chosen: the value that was left to the map and what it costs; None when all were given.
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
    scenario: Mapping[str, Any] = field(default_factory=dict, repr=False)
    chosen: ChosenValue | None = None

    def motion(self, swing_apex: float | Literal["planned"] | None = "planned", point: Point = "com") -> Motion:
        """The plan at any time, cycle after cycle; its swings rise `swing_apex` m above the higher of their footholds.

        By default that is the plan's own `swing_apex`. With None the feet are the plan's own. Position, velocity and
        acceleration are those of the centre of mass, or with `point="base"` of the base link's frame. Raises ValueError
        as `Motion.of`.
        """
        apex = self.swing_apex if swing_apex == "planned" else swing_apex
        return Motion.of(self.scenario, self, self._whole_task, self.pattern, apex, point)

    @property
    def _whole_task(self) -> Task:
        """The task with the axes that the map holds at one value."""
        space = TaskSpace.of(self.scenario)
        return space.task({axis: self.task[axis] for axis in space.ranged})

    @property
    def cost_of_transport(self) -> float | None:
        """The cost over the weight, payload included, and over the distance of a cycle.

        None where the map's objective is not energy, or where the robot stays where it is.
        """
        objective = self.scenario.get("objective", {})
        if not objective.get("joint_heat") and not objective.get("joint_work"):
            return None
        task = self._whole_task
        way = math.hypot(task["speed"], task["lateral_speed"]) * task.cycle_duration
        weight = (float(self.scenario["robot"]["mass"]) + task["payload"]) * GRAVITY
        return self.cost / (weight * way) if way else None

    @property
    def swing_apex(self) -> float:
        """How high swings lead [m] where the map counts on it, as one of energy does; 0.05 otherwise."""
        return float(self.scenario.get("swing_clearance", 0.0)) or SWING_APEX

    @property
    def frames(self) -> Frames | None:
        """Where the robot's links are, seen from what the plan speaks of; None of a map that does not know them."""
        return Frames.of(self.scenario)


@dataclass(frozen=True)
class Asked:
    """The task of a plan, its values by axis, what the map said of it, and `perf_counter()` when the call began."""

    task: Task
    values: Mapping[str, float]
    in_domain: bool
    distance: float
    started: float


def refine_ranked(
    refiner: GaitRefiner, ranked: Sequence[tuple[Candidate, Gait, float]], asked: Asked, top: int = TOP
) -> Plan:
    """Refine the candidates (candidate, gait, probability) in order until one converges to a feasible motion.

    Only those of the first `top` gaits are tried so. Then all others that may cost less than that came to are refined
    as well, and the cheapest one is taken if it does: before a cliff of the cost and across its kinks predictions are
    far off, and their nodes disagree. `likely` gaits are refined in any case, and `unlikely` ones only if they come
    first.
    IPOPT is asked only when the fast method has failed for all of them, once a gait: where the first gait has no
    motion, as beyond its longest stride, it takes a second to find that out, and a planner cannot wait for it.
    """
    selected = time.perf_counter()
    candidates = [candidate for candidate, _, _ in ranked]
    chances = {candidate.gait: probability for candidate, _, probability in ranked}
    firsts = _firsts(candidates, likely(refiner.atlas, chances))
    sure = {place: chances[candidates[place].gait] for place in firsts}
    spared = _spared(candidates, unlikely(refiner.atlas, chances))
    attempts = list(_attempts(refiner, candidates, sure, spared, asked.task, top))
    best, attempt = min(attempts, key=_merit)
    first, solved = next((each for each in attempts if each[1].refined), (best, attempt))
    if attempt.cost > solved.cost * (1 - LEAST_SAVING):  # of gaits that tie, the one that `select` names
        best, attempt = first, solved
    _, gait, probability = ranked[best]
    last = {place: done for place, done in attempts}
    gaits = list(dict.fromkeys(candidate.gait for candidate in candidates))
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
        path=_path(attempt, gaits.index(candidates[best].gait), gaits.index(candidates[first].gait)),
        tried=tuple((ranked[place][1].name, _outcome(last[place])) for place in sorted(last)),
        select_ms=(selected - asked.started) * 1e3,
        predict_ms=sum(done.predict_ms for _, done in attempts),
        refine_ms=sum(done.refine_ms for _, done in attempts),
        time_ms=(time.perf_counter() - asked.started) * 1e3,
    )


def _attempts(
    refiner: GaitRefiner,
    candidates: Sequence[Candidate],
    sure: Mapping[int, float],
    spared: set[int],
    task: Task,
    top: int,
) -> Iterator[tuple[int, Attempt]]:
    gaits = list(dict.fromkeys(candidate.gait for candidate in candidates))[:top]
    places = [place for place, candidate in enumerate(candidates) if candidate.gait in gaits]
    for number, place in enumerate(places):
        attempt = refiner.fast(candidates[place], task)
        yield place, attempt
        if attempt.refined:
            done = spared.union(places[: number + 1])
            yield from _cheaper(refiner, candidates, sure, done, (place, attempt.cost), task)
            return
    first = {candidates[place].gait: place for place in reversed(places)}
    for place in sorted(first.values()):
        attempt = refiner.fallback(candidates[place], task)
        yield place, attempt
        if attempt.refined:
            return


def _cheaper(
    refiner: GaitRefiner,
    candidates: Sequence[Candidate],
    sure: Mapping[int, float],
    done: Set[int],
    solved: tuple[int, float],
    task: Task,
) -> Iterator[tuple[int, Attempt]]:
    """An attempt for each candidate left that may cost less than the cheapest so far, the most promising first.

    `solved` is the place of the first one that was solved, with its cost. Candidates of `sure`, with their
    probabilities, are tried whatever they may cost, those of `done` not.
    """
    first, cost = solved
    least = refiner.least(candidates, task)
    share = tried_below(refiner.atlas, least[first], cost)
    for place in sorted(range(len(candidates)), key=least.__getitem__):
        if place not in done and (place in sure or least[place] < cost * share):
            attempt = refiner.fast(candidates[place], task, effort_for(least[place], cost, sure.get(place, 0.0)))
            yield place, attempt
            if attempt.refined:
                cost = min(cost, attempt.cost)


def _spared(candidates: Sequence[Candidate], gaits: Set[int]) -> set[int]:
    """The places of all candidates of gaits, but of the gait that comes first."""
    return {place for place, each in enumerate(candidates) if each.gait in gaits - {candidates[0].gait}}


def _firsts(candidates: Sequence[Candidate], gaits: Set[int]) -> set[int]:
    """The place of the first candidate of each gait that the atlas knows."""
    places = reversed(range(len(candidates)))
    first = {candidates[place].gait: place for place in places if candidates[place].sheet is not None}
    return {first[gait] for gait in gaits if gait in first}


def _merit(each: tuple[int, Attempt]) -> tuple[bool, float]:
    """Least first: refined motions by cost, others by violation."""
    _, attempt = each
    return (False, attempt.cost) if attempt.refined else (True, attempt.violation)


def _path(attempt: Attempt, best: int, first: int) -> str:
    """`first` is the place of the first gait that refined, `best` of the one taken, by this attempt."""
    if not attempt.refined:
        return "failed"
    if best == 0:
        return attempt.method
    return f"next:{best}" if best == first else f"cheaper:{best}"


def _outcome(attempt: Attempt) -> str:
    if attempt.refined:
        return f"solved, {attempt.method}"
    fault = "not converged" if attempt.feasible else f"infeasible: violation {attempt.violation:.1e}"
    return f"{fault} after {attempt.iterations} iterations ({attempt.solver_status})"
