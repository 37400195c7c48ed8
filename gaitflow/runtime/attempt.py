"""A gait refined at a task: what comes out, judged by our own check, whoever solved it."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from gaitflow.core import check
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.manifest import Manifest
from gaitflow.solvers.options import CONVERGED

FAST, FALLBACK = "fast", "fallback"
NOT_CONVERGED = "not converged"  # what is no status of CONVERGED


class Effort(IntEnum):
    """How hard a candidate is tried: as a rival, as one that promises much, or as the first of a plan."""

    RIVAL = 1
    PROMISING = 2
    FIRST = 3


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


@dataclass
class Run:
    """A candidate being refined for a task; times are `perf_counter()` at the call, and when its start was there."""

    candidate: Candidate
    task: Task
    started: float
    ready: float
    iterations: int = 0


class GaitRefiner(ABC):
    """Refines a map's gaits. For one thread."""

    def __init__(self, manifest: Manifest, atlas: Atlas) -> None:
        self.manifest, self.atlas = manifest, atlas

    @abstractmethod
    def fast(self, candidate: Candidate, task: Task, effort: Effort = Effort.FIRST) -> Attempt:
        """Solve for a task by Newton steps from one start after the other."""

    @abstractmethod
    def fallback(self, candidate: Candidate, task: Task) -> Attempt:
        """Solve for a task by IPOPT."""

    def least(self, candidates: Sequence[Candidate], task: Task) -> list[float]:
        """What candidates may cost at a task at the least, in the scenario's units; infinite when nobody knows."""
        costs = self.atlas.least_costs(self.place(task)) * self.manifest.cost_scale
        return [float("inf") if each.sheet is None else float(costs[each.sheet]) for each in candidates]

    def place(self, task: Task) -> Array:
        """The task by its values on the map's axes [axes]."""
        return np.array(task.on(self.atlas.axes))

    def judged(self, run: Run, w: Array, cost: float, method: str, status: str) -> Attempt:
        """The motion w [nw] with our check's verdict; cost in the scenario's units."""
        manifest = self.manifest
        trajectory = manifest.layout.unpack(w, run.task.cycle_duration)
        pattern = self._pattern(run.candidate)
        return Attempt(
            trajectory=trajectory,
            pattern=pattern,
            cost=cost,
            violation=check.worst(manifest.scenario, trajectory, run.task, pattern),
            iterations=run.iterations,
            solver_status=status,
            method=method,
            predict_ms=(run.ready - run.started) * 1e3,
            refine_ms=(time.perf_counter() - run.ready) * 1e3,
        )

    def _pattern(self, candidate: Candidate) -> str:
        if candidate.sheet is None:
            return self.manifest.gaits[candidate.gait].pattern
        return self.atlas.sheets[candidate.sheet].pattern
