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
from gaitflow.runtime.attempt import FALLBACK, FAST, NOT_CONVERGED, Attempt, Candidate, Effort, GaitRefiner, Run
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
RIVAL_LIMIT = 30  # of each try of a candidate that may save a little: no plan of 137 came out dearer than with 60
FIRST_STARTS, PROMISING_STARTS, RIVAL_STARTS = 4, 2, 2  # of a candidate, by `Effort`
LEAST_COST = 1e-9


def tries_of(atlas: Atlas, effort: Effort) -> tuple[int, int]:
    """How many starts a candidate has, and the iterations of each.

    A rival has one start where the nominal one comes first, which leads to a motion in the end.
    """
    if effort is Effort.RIVAL:
        return (1, LIMIT) if atlas.is_wide else (RIVAL_STARTS, RIVAL_LIMIT)
    return (FIRST_STARTS if effort is Effort.FIRST else PROMISING_STARTS), LIMIT


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

    def fast(self, candidate: Candidate, task: Task, effort: Effort = Effort.FIRST) -> Attempt:
        """Solve for a task by the fast method, from the `starts_of` the candidate's sheet, as `tries_of` says.

        A candidate that the atlas does not know is solved from the mean of its region. Where it does not converge the
        motion is the last try's.
        """
        started = time.perf_counter()
        parameters, method = task.parameters, self.method(candidate)
        starts, (most, limit) = self._starts(candidate, method.space, task), tries_of(self.atlas, effort)
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
