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

from gaitflow.core import check
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.layout import unpack
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.problem import CONVERGED, Problem
from gaitflow.runtime.tensors import GaitTensors
from gaitflow.solvers.interior_point import InteriorPoint
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program

FAST, FALLBACK = "fast", "fallback"
QUICK = 18  # iterations of the first try, from a prediction between the nodes
STEADY_BARRIER, STEADY = 1e-3, 25  # of a further one, from a node itself: a higher barrier is more patient
NODES = 2
MEAN_BARRIER, MEAN = 1e-2, 30  # from the mean of a region, far off
LEAST_COST = 1e-9


@dataclass(frozen=True)
class Attempt:
    """One gait refined: what came out, for which full pattern, our own verdict on it, and what the solver said.

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
        self._program = Program(problem.function, problem.derivatives)
        self._methods: dict[tuple[int, int | None], InteriorPoint] = {}
        for number, sheet in enumerate(atlas.sheets):
            self.method(Candidate(sheet.gait, number))

    def fast(self, candidate: Candidate, speed: float, cycle_duration: float, most: int = 1 + NODES) -> Attempt:
        """Solve for a task (m/s, s) by the fast method: from the prediction, then from nodes nearby, or from the mean.

        `most` is how many of these may be tried. Where it does not converge the motion is the last try's.
        """
        started = time.perf_counter()
        task = np.array([speed, cycle_duration])
        method = self.method(candidate)
        tries = self._tries(candidate, method.space, task)
        first = next(tries)
        run = _Run(candidate, task, started, time.perf_counter())
        for each in itertools.islice(itertools.chain([first], tries), most):
            outcome = method.follow(task, each.start, each.unit, each.barrier, each.limit)
            run.iterations += outcome.iterations
            status = CONVERGED[0] if outcome.converged else "not converged"
            if outcome.converged:
                attempt = self._judged(run, outcome.w, outcome.cost, status, FAST)
                if attempt.feasible:
                    return attempt
        return self._judged(run, outcome.w, outcome.cost, status, FAST)

    def least(self, candidate: Candidate, speed: float, cycle_duration: float) -> float:
        """What a candidate may cost at a task at the least, in the scenario's units; infinite when nobody knows."""
        if candidate.sheet is None:
            return float("inf")
        return self._atlas.least_cost(candidate.sheet, speed, cycle_duration) * self._manifest.cost_scale

    def fallback(self, candidate: Candidate, speed: float, cycle_duration: float) -> Attempt:
        """Solve for a task (m/s, s) by IPOPT: from the prediction, then from the mean of the region."""
        started = time.perf_counter()
        task, space = np.array([speed, cycle_duration]), self._space(candidate)
        first = next(self._tries(candidate, space, task))
        run = _Run(candidate, task, started, time.perf_counter())
        mean = self._tensors.mean(candidate.gait)
        starts = [mean] if candidate.sheet is None else [space.join(first.start, first.unit), mean]
        for primal, bounds, rows in starts:
            answer = self._problem.ipopt(space, task, primal, bounds, rows)
            run.iterations += answer.iterations
            attempt = self._judged(run, answer.w, self._problem.cost(answer.w, task), answer.status, FALLBACK)
            if attempt.refined:
                break
        return attempt

    def method(self, candidate: Candidate) -> InteriorPoint:
        """The fast method of a candidate's pattern; of one without a sheet, made when it is asked for first."""
        key = candidate.gait, candidate.sheet
        if key not in self._methods:
            self._methods[key] = InteriorPoint(self._program, self._space(candidate))
        return self._methods[key]

    def _space(self, candidate: Candidate) -> GaitSpace:
        if candidate.sheet is None:
            return self._tensors.space(candidate.gait)
        return self._atlas.sheets[candidate.sheet].space

    def _pattern(self, candidate: Candidate) -> str:
        if candidate.sheet is None:
            return self._manifest.gaits[candidate.gait].pattern
        return self._atlas.sheets[candidate.sheet].pattern

    def _tries(self, candidate: Candidate, space: GaitSpace, task: Array) -> Iterator[_Try]:
        """Where the fast method may start, the best first."""
        speed, cycle_duration = map(float, task)
        if candidate.sheet is not None:
            predicted = self._atlas.predict(candidate.sheet, speed, cycle_duration)
            if predicted is not None:
                yield _Try(space.decode(predicted.point), predicted.cost, self._atlas.barrier, QUICK)
            for node in self._atlas.nearest(candidate.sheet, speed, cycle_duration, NODES):
                yield _Try(space.decode(node.point), node.cost, STEADY_BARRIER, STEADY)
            return
        primal, bounds, rows = self._tensors.mean(candidate.gait)
        unit = max(self._problem.cost(primal, task), LEAST_COST)
        yield _Try(space.split(primal, bounds, rows, unit), unit, MEAN_BARRIER, MEAN)

    def _judged(self, run: _Run, w: Array, cost: float, status: str, method: str) -> Attempt:
        manifest, (speed, cycle_duration) = self._manifest, map(float, run.task)
        trajectory = unpack(manifest.layout, self._tensors.scale, w, cycle_duration)
        pattern = self._pattern(run.candidate)
        violation = check.worst(manifest.scenario, trajectory, speed, cycle_duration, pattern)
        return Attempt(
            trajectory=trajectory,
            pattern=pattern,
            cost=cost * manifest.cost_scale,
            violation=violation,
            iterations=run.iterations,
            solver_status=status,
            method=method,
            predict_ms=(run.ready - run.started) * 1e3,
            refine_ms=(time.perf_counter() - run.ready) * 1e3,
        )


@dataclass(frozen=True)
class _Try:
    start: Point
    unit: float  # the cost that is expected
    barrier: float
    limit: int


@dataclass
class _Run:
    candidate: Candidate
    task: Array
    started: float
    ready: float
    iterations: int = 0
