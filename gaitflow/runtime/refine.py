"""Refining a gait's predicted start into a motion: Newton steps on the central path, and IPOPT where they fail.

Whoever solved it, a motion counts when it converged and `gaitflow.core.check`, which shares nothing with the problem,
finds it feasible.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gaitflow.core import check
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.tensors import GaitTensors
from gaitflow.solvers.interior_point import InteriorPoint
from gaitflow.solvers.options import CONVERGED
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program

FAST, FALLBACK = "fast", "fallback"
# Barriers of the tries, by what they start from. Far starts take a higher barrier. Of 400 near solves the first try,
# with a matrix of the right inertia, found 94 %, of which 0.5 % were 0.1 % dearer than the best known; without looking
# after the inertia 4.8 %. Of the 6 % the second one found 92 %, more than any other.
PRIMAL_BARRIER = 1e-2  # the prediction without its multipliers
NODE_BARRIER = 1e-3
MEAN_BARRIER = 1e-2
LIMIT = 60  # iterations of a try: near cliffs some need twice the usual 25, and another start takes as many again
LEAST_COST = 1e-9


@dataclass(frozen=True)
class Attempt:
    """One gait refined: what came out, for which pattern, our own verdict on it, and what the solver said.

    cost in the scenario's units; violation is the worst scaled one (gaitflow.core.check). method: "fast" or "fallback".
    iterations are Newton's and IPOPT's. predict_ms and refine_ms are wall times, checking included.
    """

    trajectory: Trajectory
    pattern: str
    cost: float
    violation: float
    iterations: int
    solver_status: str
    method: str
    predict_ms: float
    refine_ms: float

    @property
    def feasible(self) -> bool:
        """Whether the check, not the solver, finds the trajectory feasible."""
        return self.violation <= check.FEASIBLE

    @property
    def refined(self) -> bool:
        """Feasible and a minimum: the solver's word is needed for the second, and never enough for the first."""
        return self.feasible and self.solver_status in CONVERGED


@dataclass(frozen=True)
class Candidate:
    """Gait number `gait` of the map by a sheet of the atlas, or from the mean of its region when `sheet` is None."""

    gait: int
    sheet: int | None


class Refiner:
    """A map's gaits, each pattern with a matrix of its own, ordered here and now. `problem` may be shared by threads.

    For one thread.
    """

    def __init__(self, problem: Problem, manifest: Manifest, tensors: GaitTensors, atlas: Atlas) -> None:
        self._problem = problem
        self._manifest = manifest
        self._tensors = tensors
        self._atlas = atlas
        self._program = Program(problem.separable, problem.derivatives)
        self._methods: dict[tuple[int, int | None], InteriorPoint] = {}
        for number, sheet in enumerate(atlas.sheets):
            self.method(Candidate(sheet.gait, number))

    def fast(self, candidate: Candidate, task: Task, most: int = 3) -> Attempt:
        """Solve for a task by the fast method: from the prediction, with and without its multipliers, then from a node.

        A candidate that the atlas does not know is solved from the mean of its region. `most` is how many tries there
        may be. Where it does not converge the motion is the last try's.
        """
        started = time.perf_counter()
        parameters, method = task.parameters, self.method(candidate)
        tries = self._tries(candidate, method.space, task)
        first = next(tries)
        run = _Run(candidate, task, started, time.perf_counter())
        for each in itertools.islice(itertools.chain([first], tries), most):
            outcome = method.follow(parameters, each.start, each.unit, each.barrier, LIMIT, each.predicted)
            run.iterations += outcome.iterations
            status = CONVERGED[0] if outcome.converged else "not converged"
            if outcome.converged:
                attempt = self._judged(run, outcome.w, outcome.cost, status, FAST)
                if attempt.feasible:
                    return attempt
        return self._judged(run, outcome.w, outcome.cost, status, FAST)

    def least(self, candidates: Sequence[Candidate], task: Task) -> list[float]:
        """What candidates may cost at a task at the least, in the scenario's units; infinite when nobody knows."""
        costs = self._atlas.least_costs(self._place(task)) * self._manifest.cost_scale
        return [float("inf") if each.sheet is None else float(costs[each.sheet]) for each in candidates]

    def fallback(self, candidate: Candidate, task: Task) -> Attempt:
        """Solve for a task by IPOPT: from the prediction, then from the mean of the region."""
        started = time.perf_counter()
        parameters, space = task.parameters, self._space(candidate)
        first = next(self._tries(candidate, space, task))
        run = _Run(candidate, task, started, time.perf_counter())
        mean = self._tensors.mean(candidate.gait)
        starts = [mean] if candidate.sheet is None else [space.join(first.start, first.unit), mean]
        for primal, bounds, rows in starts:
            answer = self._problem.ipopt(space, parameters, primal, bounds, rows)
            run.iterations += answer.iterations
            cost = self._problem.cost(answer.w, parameters)
            attempt = self._judged(run, answer.w, cost, answer.status, FALLBACK)
            if attempt.refined:
                break
        return attempt

    def method(self, candidate: Candidate) -> InteriorPoint:
        """The fast method of a candidate's pattern; of one without a sheet, made when it is asked for first."""
        key = candidate.gait, candidate.sheet
        if key not in self._methods:
            self._methods[key] = InteriorPoint(self._program, self._space(candidate))
        return self._methods[key]

    def _place(self, task: Task) -> Array:
        return np.array(task.on(self._atlas.axes))

    def _space(self, candidate: Candidate) -> GaitSpace:
        if candidate.sheet is None:
            return self._tensors.space(candidate.gait)
        return self._atlas.sheets[candidate.sheet].space

    def _pattern(self, candidate: Candidate) -> str:
        if candidate.sheet is None:
            return self._manifest.gaits[candidate.gait].pattern
        return self._atlas.sheets[candidate.sheet].pattern

    def _tries(self, candidate: Candidate, space: GaitSpace, task: Task) -> Iterator[_Try]:
        """Where the fast method may start, the best first."""
        if candidate.sheet is not None:
            place = self._place(task)
            predicted = self._atlas.predict(candidate.sheet, place)
            if predicted is not None:
                point = space.decode(predicted.point)
                yield _Try(point, predicted.cost, self._atlas.barrier, predicted=True)
                yield _Try(_primal(point), predicted.cost, PRIMAL_BARRIER)
            # The nearest node says little that is new: the prediction is mostly its own.
            node = self._atlas.nearest(candidate.sheet, place, 2)[-1]
            yield _Try(space.decode(node.point), node.cost, NODE_BARRIER)
            return
        primal, bounds, rows = self._tensors.mean(candidate.gait)
        unit = max(self._problem.cost(primal, task.parameters), LEAST_COST)
        yield _Try(space.split(primal, bounds, rows, unit), unit, MEAN_BARRIER)

    def _judged(self, run: _Run, w: Array, cost: float, status: str, method: str) -> Attempt:
        manifest = self._manifest
        trajectory = manifest.layout.unpack(w, run.task.cycle_duration)
        pattern = self._pattern(run.candidate)
        return Attempt(
            trajectory=trajectory,
            pattern=pattern,
            cost=cost * manifest.cost_scale,
            violation=check.worst(manifest.scenario, trajectory, run.task, pattern),
            iterations=run.iterations,
            solver_status=status,
            method=method,
            predict_ms=(run.ready - run.started) * 1e3,
            refine_ms=(time.perf_counter() - run.ready) * 1e3,
        )


def _primal(point: Point) -> Point:
    """The point without its multipliers: those of bounds follow from the barrier."""
    nothing = np.zeros_like(point.lower)
    return Point(point.free, np.zeros_like(point.rows), nothing, nothing)


@dataclass(frozen=True)
class _Try:
    start: Point
    unit: float  # the cost that is expected
    barrier: float
    predicted: bool = False  # for this task, unit and all: then each step looks after the matrix's inertia


@dataclass
class _Run:
    candidate: Candidate
    task: Task
    started: float
    ready: float
    iterations: int = 0
