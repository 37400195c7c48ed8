"""Refining a gait's predicted start into a motion: Newton steps on the central path, and IPOPT where they fail.

Whoever solved it, a motion counts when it converged and `gaitflow.core.check`, which shares nothing with the problem,
finds it feasible.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gaitflow.core.task import Task
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.attempt import FALLBACK, FAST, NOT_CONVERGED, STARTS, Attempt, Candidate, GaitRefiner, Run
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.tensors import GaitTensors
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.options import CONVERGED
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program

# Barriers of the tries, by what they start from. Far starts take a higher barrier. Of 400 near solves the first try,
# with a matrix of the right inertia, found 94 %, of which 0.5 % were 0.1 % dearer than the best known; without looking
# after the inertia 4.8 %. Of the 6 % the second one found 92 %, more than any other.
PRIMAL_BARRIER = 1e-2  # the prediction without its multipliers
NODE_BARRIER = 1e-3
MEAN_BARRIER = 1e-2
LIMIT = 60  # iterations of a try: near cliffs some need twice the usual 25, and another start takes as many again
RIVAL_LIMIT = 30  # of a candidate that may be cheaper, and has fewer tries: no plan of 137 came out dearer than with 60
LEAST_COST = 1e-9


class Refiner(GaitRefiner):
    """A map's gaits, each pattern with a matrix of its own, ordered here and now. `problem` may be shared by threads.

    For one thread.
    """

    def __init__(self, problem: Problem, manifest: Manifest, tensors: GaitTensors, atlas: Atlas) -> None:
        super().__init__(manifest, atlas)
        self._problem = problem
        self._tensors = tensors
        self._program = Program(problem.separable, problem.derivatives)
        self._methods: dict[tuple[int, int | None], InteriorPoint] = {}
        for number, sheet in enumerate(atlas.sheets):
            self.method(Candidate(sheet.gait, number))

    def fast(self, candidate: Candidate, task: Task, most: int = STARTS) -> Attempt:
        """Solve for a task by the fast method: from the prediction, with and without its multipliers, then from a node.

        A candidate that the atlas does not know is solved from the mean of its region. `most` is how many tries there
        may be. Where it does not converge the motion is the last try's.
        """
        started = time.perf_counter()
        parameters, method = task.parameters, self.method(candidate)
        tries, limit = self._tries(candidate, method.space, task), LIMIT if most >= STARTS else RIVAL_LIMIT
        first = next(tries)
        run = Run(candidate, task, started, time.perf_counter())
        for each in itertools.islice(itertools.chain([first], tries), most):
            outcome = method.follow(parameters, each.start, each.unit, each.barrier, limit, each.predicted)
            run.iterations += outcome.iterations
            if outcome.converged:
                attempt = self._fast(run, outcome)
                if attempt.feasible:
                    return attempt
        return self._fast(run, outcome)

    def fallback(self, candidate: Candidate, task: Task) -> Attempt:
        """Solve for a task by IPOPT: from the prediction, then from the mean of the region."""
        started = time.perf_counter()
        parameters, space = task.parameters, self._space(candidate)
        first = next(self._tries(candidate, space, task))
        run = Run(candidate, task, started, time.perf_counter())
        mean = self._tensors.mean(candidate.gait)
        starts = [mean] if candidate.sheet is None else [space.join(first.start, first.unit), mean]
        for primal, bounds, rows in starts:
            answer = self._problem.ipopt(space, parameters, primal, bounds, rows)
            run.iterations += answer.iterations
            cost = self._problem.cost(answer.w, parameters) * self.manifest.cost_scale
            attempt = self.judged(run, answer.w, cost, FALLBACK, answer.status)
            if attempt.refined:
                break
        return attempt

    def method(self, candidate: Candidate) -> InteriorPoint:
        """The fast method of a candidate's pattern; of one without a sheet, made when it is asked for first."""
        key = candidate.gait, candidate.sheet
        if key not in self._methods:
            self._methods[key] = InteriorPoint(self._program, self._space(candidate))
        return self._methods[key]

    def _fast(self, run: Run, outcome: Outcome) -> Attempt:
        status = CONVERGED[0] if outcome.converged else NOT_CONVERGED
        return self.judged(run, outcome.w, outcome.cost * self.manifest.cost_scale, FAST, status)

    def _space(self, candidate: Candidate) -> GaitSpace:
        if candidate.sheet is None:
            return self._tensors.space(candidate.gait)
        return self.atlas.sheets[candidate.sheet].space

    def _tries(self, candidate: Candidate, space: GaitSpace, task: Task) -> Iterator[_Try]:
        """Where the fast method may start, the best first."""
        if candidate.sheet is not None:
            place = self.place(task)
            predicted = self.atlas.predict(candidate.sheet, place)
            if predicted is not None:
                point = space.decode(predicted.point)
                yield _Try(point, predicted.cost, self.atlas.barrier, predicted=True)
                yield _Try(_primal(point), predicted.cost, PRIMAL_BARRIER)
            # The nearest node says little that is new: the prediction is mostly its own.
            node = self.atlas.nearest(candidate.sheet, place, 2)[-1]
            yield _Try(space.decode(node.point), node.cost, NODE_BARRIER)
            return
        primal, bounds, rows = self._tensors.mean(candidate.gait)
        unit = max(self._problem.cost(primal, task.parameters), LEAST_COST)
        yield _Try(space.split(primal, bounds, rows, unit), unit, MEAN_BARRIER)


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
