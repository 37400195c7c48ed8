"""Refining a gait's predicted start into a motion: Newton steps on the central path, and IPOPT where they fail.

Whoever solved it, a motion counts when it converged and `gaitflow.core.check`, which shares nothing with the problem,
finds it feasible.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from functools import partial

from gaitflow.core.task import Task
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.attempt import FALLBACK, FAST, NOT_CONVERGED, STARTS, Attempt, Candidate, GaitRefiner, Run
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.problem import Problem
from gaitflow.runtime.starts import Start, starts_of
from gaitflow.runtime.tensors import GaitTensors
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.options import CONVERGED
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import Program

MEAN_BARRIER = 1e-2  # of the mean of a region, far from any task
LIMIT = 60  # iterations of a try: near cliffs some need twice the usual 25, and another start takes as many again
RIVAL_LIMIT = 30  # of a candidate that may save a little, and has one try: no plan of 137 came out dearer than with 60
LEAST_COST = 1e-9


def limit_of(atlas: Atlas, most: int) -> int:
    """The iterations of each of at most `most` tries of a candidate; the nominal start leads to a motion in the end."""
    return RIVAL_LIMIT if most == 1 and not atlas.is_wide else LIMIT


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
        """Solve for a task by the fast method, from the `starts_of` the candidate's sheet.

        A candidate that the atlas does not know is solved from the mean of its region. `most` is how many tries there
        may be. Where it does not converge the motion is the last try's.
        """
        started = time.perf_counter()
        parameters, method = task.parameters, self.method(candidate)
        starts, limit = self._starts(candidate, method.space, task), limit_of(self.atlas, most)
        first = next(starts)
        run = Run(candidate, task, started, time.perf_counter())
        for each in itertools.islice(itertools.chain([first], starts), most):
            outcome = method.follow(parameters, each.point, each.unit, each.barrier, limit, each.careful)
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
        first = next(self._starts(candidate, space, task))
        run = Run(candidate, task, started, time.perf_counter())
        mean = self._tensors.mean(candidate.gait)
        starts = [mean] if candidate.sheet is None else [space.join(first.point, first.unit), mean]
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

    def _starts(self, candidate: Candidate, space: GaitSpace, task: Task) -> Iterator[Start]:
        """Where the fast method may start, the best first."""
        if candidate.sheet is not None:
            nominal = partial(self._problem.nominal, task)
            yield from starts_of(self.atlas, candidate.sheet, self.place(task), nominal)
            return
        primal, bounds, rows = self._tensors.mean(candidate.gait)
        unit = max(self._problem.cost(primal, task.parameters), LEAST_COST)
        yield Start(space.split(primal, bounds, rows, unit), unit, MEAN_BARRIER)
