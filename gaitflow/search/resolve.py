"""Whether the mesh decides which gait of a task is best: the cheapest gaits, solved again on finer meshes.

A cost has an error that falls with the number of knots in a phase and differs between gaits. So the cheapest gait and
the runner-up are solved once more with twice the knots. Where their costs there lie farther apart than what may be
left of their errors, or closer than TIE, the task is resolved. Otherwise these two, and every other gait that may be
cheaper within the error, are solved with four times the knots, and at last with MOST_KNOTS.

Scenarios with Euler's rule are left as they are: the paper's section III.B takes its 10 knots for granted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.mesh_error import error_left
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Multipliers, NewSolver, Start

MOST_KNOTS = 50  # a phase, on the finest mesh
TIE = 1e-3  # relative cost within which gaits tie, as learning.tie_tolerance is unless a scenario says otherwise


class FinerMeshes:
    """The solvers of a scenario on its finer meshes, each built when it is first needed."""

    def __init__(self, scenario: Scenario, new_solver: NewSolver = FixedGaitSolver) -> None:
        self._scenario = scenario
        self._new_solver = new_solver
        self._layout = Layout.of(scenario.as_data())
        self._knots = scenario.transcription.knots_per_phase
        self._solvers: dict[int, FixedGaitSolver] = {}

    @property
    def meshes(self) -> tuple[int, ...]:
        """Knots a phase of the finer meshes, in the order in which they are asked."""
        if self._scenario.transcription.integrator == "euler":
            return ()
        return tuple(sorted({min(factor * self._knots, MOST_KNOTS) for factor in (2, 4, 8)} - {self._knots}))

    def resolved(self, task: Task, rows: Sequence[Solution]) -> list[Solution]:
        """All the rows of one task, with refined costs where they were needed."""
        result = list(rows)
        places = {row.pattern: place for place, row in enumerate(rows)}
        gaits = _cheapest_of_each_gait(rows)
        asked = gaits[:2]
        for knots in self.meshes:
            asked = [self.on_mesh(task, row, knots) for row in asked]
            for row in asked:
                result[places[row.pattern]] = row
            if len(asked) < 2 or any(row.refined_knots != knots for row in asked) or self._resolves(asked):
                break
            reach = min(row.cost for row in asked) * (1 + max(_gap(row) for row in asked))
            known = {row.pattern for row in asked}
            asked += [row for row in gaits if row.pattern not in known and row.cost <= reach]
        return result

    def _resolves(self, rows: Sequence[Solution]) -> bool:
        """Whether the finer mesh says which of the rows is cheapest, or that the first two tie.

        A unit of work, which has to depend on the search alone, does not know the learning's tolerance: hence TIE.
        """
        first, second = sorted(rows, key=lambda row: (row.refined_cost, row.pattern))[:2]
        margin = (second.refined_cost - first.refined_cost) / abs(first.refined_cost)
        errors = [error_left(row.cost, self._knots, row.refined_cost, row.refined_knots) for row in (first, second)]
        return margin <= TIE or margin > max(errors)

    def on_mesh(self, task: Task, row: Solution, knots: int) -> Solution:
        """The row with its cost on a finer mesh; without it when no motion was found there. The effort counts."""
        solver = self._solver(knots)
        assert row.trajectory is not None
        pattern = Pattern.from_text(row.pattern)
        start = on_other_mesh("coarser", row.trajectory, self._layout, solver.problem, task)
        attempts = [solver.solve(pattern, task, start)]
        if not attempts[0].feasible:
            attempts.append(solver.solve(pattern, task, replace(start, multipliers=None)))
        spent = replace(
            row,
            iterations=row.iterations + sum(attempt.iterations for attempt in attempts),
            solves=row.solves + len(attempts),
            wall_s=row.wall_s + sum(attempt.wall_s for attempt in attempts),
            cpu_s=row.cpu_s + sum(attempt.cpu_s for attempt in attempts),
        )
        found = attempts[-1]
        return replace(spent, refined_cost=found.cost, refined_knots=knots) if found.feasible else spent

    def _solver(self, knots: int) -> FixedGaitSolver:
        if knots not in self._solvers:
            settings = self._scenario.transcription.model_copy(update={"knots_per_phase": knots})
            finer = self._scenario.model_copy(update={"transcription": settings})
            self._solvers[knots] = self._new_solver(transcribe(finer), self._scenario.strategy.solve_time_limit)
        return self._solvers[knots]


def on_other_mesh(name: str, motion: Trajectory, given: Layout, problem: GaitProblem, task: Task) -> Start:
    """The start from a motion of another layout.

    Multipliers of 0 stand for unknown ones: with them the solver stays near its start, in the same local optimum.
    """
    w = problem.layout.pack(interpolated(motion, given, problem.layout), task.cycle_duration)
    return Start(name, w, Multipliers(np.zeros(problem.layout.nw), np.zeros(problem.ng)))


def interpolated(motion: Trajectory, given: Layout, wanted: Layout) -> Trajectory:
    """A motion with the same phases on a mesh with other knots: a start for a solve there.

    Positions are those of the cubic through both ends' velocities, all else runs linearly between the knots. No force
    is mixed with one of another phase.
    """
    d, a = given.dimension, given.angles
    times = wanted.times(motion.durations)
    base, feet = _linear(times, motion.times, motion.base), _linear(times, motion.times, motion.feet)
    for axis in range(d):
        base[:, axis] = _cubic(times, motion.times, motion.base[:, axis], motion.base[:, d + a + axis])
    nodes = []
    for phase in range(given.phases):
        old = slice(phase * given.knots_per_phase, (phase + 1) * given.knots_per_phase)
        new = slice(phase * wanted.knots_per_phase, (phase + 1) * wanted.knots_per_phase + 1)
        values = np.concatenate([motion.forces[old], motion.end_forces[old][-1:]])
        nodes.append(_linear(times[new], motion.times[old.start : old.stop + 1], values))
    forces, ends = np.concatenate([values[:-1] for values in nodes]), np.concatenate([values[1:] for values in nodes])
    velocities = np.diff(feet, axis=0) / np.diff(times)[:, None, None]
    return Trajectory(times, base, feet, forces, ends, velocities, motion.durations)


def _linear(times: Array, known: Array, values: Array) -> Array:
    """Values [n, ...] at times [n] between those [m, ...] at known times [m]."""
    flat = values.reshape(len(known), -1)
    columns = [np.interp(times, known, flat[:, column]) for column in range(flat.shape[1])]
    return np.column_stack(columns).reshape(len(times), *values.shape[1:])


def _cubic(times: Array, known: Array, values: Array, rates: Array) -> Array:
    """The piecewise cubic through values and rates [m] at known times [m], at times [n]."""
    step = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 2)
    h = known[step + 1] - known[step]
    t = (times - known[step]) / h
    first, last = values[step], values[step + 1]
    bend = (h * rates[step] - (last - first)) * (1 - t) + (last - first - h * rates[step + 1]) * t
    cubic: Array = (1 - t) * first + t * last + t * (1 - t) * bend
    return cubic


def _cheapest_of_each_gait(rows: Sequence[Solution]) -> list[Solution]:
    """The solved rows that have the least cost of their gait, cheapest first."""
    first: dict[str, Solution] = {}
    solved = [row for row in rows if row.status == "solved"]  # others have no cost to sort by
    for row in sorted(solved, key=lambda row: (row.cost, row.pattern)):
        first.setdefault(row.gait, row)
    return list(first.values())


def _gap(row: Solution) -> float:
    """What the scenario's mesh was off by, as far as the finer one knows."""
    return abs(row.cost - row.refined_cost) / abs(row.refined_cost)
