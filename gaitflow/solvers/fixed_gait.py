"""The fixed-gait problem: one pattern at one task from one start, solved and judged by our own check.

The interior point of this package solves it. Where it neither converges nor finds the pattern infeasible, IPOPT
decides. A start with a neighbour's multipliers that fails says nothing about the pattern; the caller then tries a start
without multipliers.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import casadi as ca
import numpy as np

from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.ipopt import call_solver, make_ipopt
from gaitflow.solvers.options import CONVERGED, IPOPT
from gaitflow.solvers.point import GaitSpace, Multipliers, Point
from gaitflow.solvers.program import Program

__all__ = ["Attempt", "FixedGaitSolver", "Method", "Multipliers", "NewSolver", "Start"]

Method = Literal["interior_point", "ipopt"]

KEPT = 6_000_000  # derivatives in the matrices that stay in memory, of the patterns used last: about 400 MB
COLD_BARRIER, WARM_BARRIER = 0.1, 1e-3  # of a start without and with multipliers
COLD_LIMIT, WARM_LIMIT = 60, 40  # iterations
UNITS = (1.0, 1 / 30, 30.0)  # what a cost may be instead of what was expected
# Any motion takes energy, and gaits differ by little of it: what a Newton step may trade for a constraint is that.
UNITS_OF_ENERGY = (0.01, 0.1, 1.0)


@dataclass(frozen=True)
class Start:
    """Where to start: w [nw] and, when known, the multipliers of a solved neighbour."""

    name: str
    w: Array
    multipliers: Multipliers | None = None


@dataclass(frozen=True)
class Attempt:
    """One solve; `feasible` is our check's verdict on a motion that converged, `cost` is unscaled."""

    start: str
    feasible: bool
    gave_up: bool  # not feasible, and the solver found no infeasibility either: a limit, an exception, a false success
    solver_status: str
    cost: float
    violation: float
    iterations: int
    wall_s: float
    cpu_s: float
    w: Array
    trajectory: Trajectory
    multipliers: Multipliers
    method: Method


NewSolver = Callable[[GaitProblem, float], "FixedGaitSolver"]  # as FixedGaitSolver's own constructor has it


@dataclass(frozen=True)
class _Answer:
    """What a method came to: the scaled cost, w [nw] and multipliers."""

    method: Method
    status: str
    cost: float
    iterations: int
    w: Array
    multipliers: Multipliers


class FixedGaitSolver:
    """Solves a scenario's problem for any pattern and task; build once, call often, one per process."""

    def __init__(self, problem: GaitProblem, time_limit: float):
        """`time_limit` is the CPU time of one call of IPOPT [s]; the interior point is bounded by its iterations."""
        self.problem = problem
        self._scenario = problem.scenario.as_data()
        self._limit = time_limit
        self._methods: OrderedDict[Pattern, InteriorPoint] = OrderedDict()

    @cached_property
    def _program(self) -> Program:
        return Program(self.problem.separable)

    @cached_property
    def _ipopt(self) -> ca.Function:
        return make_ipopt(self.problem.nlp, IPOPT | {"max_cpu_time": self._limit})

    def solve(self, pattern: Pattern, task: Task, start: Start, fallback: bool = True) -> Attempt:
        """One solve from one start. An exception is a failed attempt.

        Where the interior point gives up on a start without multipliers IPOPT tries it, if there is a `fallback`.
        """
        wall, cpu = time.perf_counter(), time.process_time()
        answer = self._interior_point(pattern, task, start)
        attempt = self._judged(pattern, task, start, answer, wall, cpu)
        if fallback and start.multipliers is None and attempt.gave_up:
            spent, answer = answer.iterations, self._by_ipopt(pattern, task, start.w)
            attempt = self._judged(pattern, task, start, answer, wall, cpu, spent)
        return attempt

    def method(self, pattern: Pattern) -> InteriorPoint:
        """The interior point of a pattern, whose matrix is ordered once."""
        if pattern in self._methods:
            self._methods.move_to_end(pattern)
            return self._methods[pattern]
        each = len(self._program.hessian) + len(self._program.jacobian)
        if self._methods and (len(self._methods) + 1) * each > KEPT:
            self._methods.popitem(last=False)
        bounds = self.problem.bounds(pattern)
        space = GaitSpace(bounds.lower, bounds.upper, bounds.lower_rows, bounds.upper_rows)
        self._methods[pattern] = InteriorPoint(self._program, space)
        return self._methods[pattern]

    def _interior_point(self, pattern: Pattern, task: Task, start: Start) -> _Answer:
        method, parameters, spent = self.method(pattern), task.parameters, 0
        expected = self._expected_cost(start.w, task)
        for unit, barrier, limit, careful in self._tries(expected, start):
            point = self._point(method.space, start, unit)
            outcome = method.follow(parameters, point, unit, barrier, limit, careful)
            spent += outcome.iterations
            if outcome.ending in ("converged", "infeasible"):
                break
        return self._answer(method.space, outcome, unit, spent)

    def _tries(self, expected: float, start: Start) -> list[tuple[float, float, int, bool]]:
        """Units of cost, barriers, limits and whether to be careful, to try in turn."""
        if start.multipliers is not None:
            return [(expected, WARM_BARRIER, WARM_LIMIT, False)]
        units = UNITS_OF_ENERGY if self.problem.scenario.objective.energy else UNITS
        return [(expected * factor, COLD_BARRIER, COLD_LIMIT, True) for factor in units]

    def _expected_cost(self, w: Array, task: Task) -> float:
        """About the scaled cost of a motion: the start's, where that is not nothing.

        A glide costs nothing where only velocities count; a body that bounces at a tenth of g costs the other number.
        """
        bouncing = (0.1 * GRAVITY * task.cycle_duration) ** 2 * task.cycle_duration / 12
        cost = float(self.problem.nlp(w, task.parameters)[0])
        return max(cost, bouncing) if np.isfinite(cost) else bouncing

    @staticmethod
    def _point(space: GaitSpace, start: Start, unit: float) -> Point:
        known = start.multipliers
        if known is None:
            return space.split(start.w, np.zeros(len(space.lower)), np.zeros(len(space.lower_rows)), 1.0)
        return space.split(start.w, known.bounds, known.rows, unit)

    @staticmethod
    def _answer(space: GaitSpace, outcome: Outcome, unit: float, iterations: int) -> _Answer:
        _, bounds, rows = space.join(outcome.point, unit)
        return _Answer("interior_point", outcome.ending, outcome.cost, iterations, outcome.w, Multipliers(bounds, rows))

    def _by_ipopt(self, pattern: Pattern, task: Task, w: Array) -> _Answer:
        bounds = self.problem.bounds(pattern)
        arguments: dict[str, Any] = {
            "x0": w,
            "p": task.parameters,
            "lbx": bounds.lower,
            "ubx": bounds.upper,
            "lbg": bounds.lower_rows,
            "ubg": bounds.upper_rows,
        }
        status, iterations, result = call_solver(self._ipopt, arguments)
        multipliers = Multipliers(result["lam_x"], result["lam_g"])
        return _Answer("ipopt", status, float(result["f"][0]), iterations, result["x"], multipliers)

    def _judged(
        self, pattern: Pattern, task: Task, start: Start, answer: _Answer, wall: float, cpu: float, spent: int = 0
    ) -> Attempt:
        """The answer with our check's verdict; `wall` and `cpu` are the times [s] at which the solve began.

        A feasible point that is not a minimum would be a wrong cost: both the status and our check must agree.
        """
        trajectory = self.problem.layout.unpack(answer.w, task.cycle_duration)
        violation = worst(self._scenario, trajectory, task, pattern.text)
        feasible = violation <= FEASIBLE and answer.status in CONVERGED
        return Attempt(
            start=start.name,
            feasible=feasible,
            gave_up=not feasible and not self._found_infeasible(answer, start),
            solver_status=answer.status,
            cost=answer.cost * self.problem.cost_scale,
            violation=violation,
            iterations=spent + answer.iterations,
            wall_s=time.perf_counter() - wall,
            cpu_s=time.process_time() - cpu,
            w=answer.w,
            trajectory=trajectory,
            multipliers=answer.multipliers,
            method=answer.method,
        )

    @staticmethod
    def _found_infeasible(answer: _Answer, start: Start) -> bool:
        if answer.method == "ipopt":
            return answer.status == "Infeasible_Problem_Detected"
        return answer.status == "infeasible" and start.multipliers is None
