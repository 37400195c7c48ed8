"""A node of the atlas: one gait solved at one task, and how its cost and its point on the central path change there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import AXIS_NAMES
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem
from gaitflow.runtime.atlas import Prediction
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program

BARRIER = 1e-4  # of the nodes: small enough to be near the optimum, large enough to feel a bound before it is met
ITERATIONS = 25
CAREFUL_BARRIER, CAREFUL_ITERATIONS = 1e-2, 100  # where a start has to be led back from a border
OTHER_UNIT = 2.0  # times the optimum's cost: between these two the path's change with the unit is measured

Place = tuple[float, ...]  # values on the axes with a range, in the order and units of AXES
Request = tuple[int, Place, Prediction]  # a pattern's number, where it is to be solved, and from which start
# Calls a method of a NodeSolver with a pattern and further arguments, for each of these, and gives what they return.
Each = Callable[[str, Sequence[tuple[Pattern, Sequence[Any]]]], list[Any]]


@dataclass(frozen=True)
class Node:
    """A solved task of a gait.

    cost: the problem's at the optimum; slopes [a]: derivatives of its logarithm along the axes with a range. point
    [ny]: the encoded point of the central path at BARRIER, for the cost divided by the optimum; tangents [a, ny]: its
    derivatives.
    """

    place: Place
    cost: float
    slopes: Array
    point: Array
    tangents: Array

    def moved(self, place: Place) -> Prediction:
        """The first-order prediction at another place."""
        offset = np.array(place) - np.array(self.place)
        return Prediction(float(self.cost * np.exp(self.slopes @ offset)), self.point + offset @ self.tangents)


class NodeSolver:
    """Solves nodes of patterns, called by their numbers, at places on the scenario's axes with a range.

    `each` calls for many requests at once, in other processes; None: one after the other, here.
    """

    def __init__(self, problem: GaitProblem, patterns: Sequence[Pattern], each: Each | None = None) -> None:
        self.patterns: tuple[Pattern, ...] = ()
        self.methods: tuple[InteriorPoint, ...] = ()
        self.solves = 0
        self._each = each
        self.problem = problem
        self._scenario = problem.scenario.as_data()
        self._space = problem.scenario.tasks.space
        self._columns = [AXIS_NAMES.index(axis) for axis in self._space.ranged]
        self._slopes = _lagrangian_slopes(problem.nlp, self._columns)
        self._program = Program(problem.separable)
        self.extend(patterns)

    def extend(self, patterns: Sequence[Pattern]) -> None:
        """Take in more patterns, numbered after those that there are."""
        bounds = [self.problem.bounds(pattern) for pattern in patterns]
        self.patterns += tuple(patterns)
        self.methods += tuple(
            InteriorPoint(self._program, GaitSpace(each.lower, each.upper, each.lower_rows, each.upper_rows))
            for each in bounds
        )

    def nodes(self, requests: Sequence[Request]) -> list[Node | None]:
        """`node` for each request."""
        return self._all("node", requests)

    def refinements(self, requests: Sequence[Request], limit: int) -> list[Outcome]:
        """`refined` for each request."""
        return self._all("refined", requests, limit)

    def costs_at(self, requests: Sequence[Request], limit: int) -> list[float | None]:
        """`cost_at` for each request."""
        return self._all("cost_at", requests, limit)

    def node(self, sheet: int, place: Place, start: Prediction) -> Node | None:
        """The node that a start leads to, along the central path to the optimum and back; None where it leads to none.

        Its motion has passed the check.
        """
        self.solves += 1
        method, task = self.methods[sheet], self.parameters(place)
        near = method.centre(task, method.space.decode(start.point), start.cost, BARRIER, ITERATIONS)
        if not near.converged:
            return None
        optimum = method.follow(task, near.point, start.cost, BARRIER, ITERATIONS)
        if not self._is_solution(sheet, place, optimum):
            return None
        cost = optimum.cost
        centred = method.centre(task, _rescaled(near.point, start.cost / cost), cost, BARRIER, ITERATIONS)
        if not centred.converged:
            return None
        _, _, rows = method.space.join(optimum.point, start.cost)
        slopes = np.asarray(self._slopes(optimum.w, task, rows), dtype=float).ravel() / cost
        tangents = self._tangents(method, task, centred.point, cost, slopes)
        point = method.space.encode(centred.point)
        return Node(place, cost, slopes, point, tangents) if _finite(slopes, point, tangents) else None

    def careful_nodes(self, requests: Sequence[Request]) -> list[Node | None]:
        """`careful_node` for each request."""
        return self._all("careful_node", requests)

    def careful_node(self, sheet: int, place: Place, start: Prediction) -> Node | None:
        """The node of a start that `node` gives up: first to the optimum, by careful steps from far off the bounds."""
        self.solves += 1
        method, task = self.methods[sheet], self.parameters(place)
        point = method.space.decode(start.point)
        found = method.follow(task, point, start.cost, CAREFUL_BARRIER, CAREFUL_ITERATIONS, careful=True)
        if not self._is_solution(sheet, place, found):
            return None
        _, bounds, rows = method.space.join(found.point, start.cost)
        return self.node(sheet, place, self.from_solution(sheet, found.w, bounds, rows, found.cost))

    def refined(self, sheet: int, place: Place, start: Prediction, limit: int) -> Outcome:
        """What a plan does: from a predicted start to the optimum, at most `limit` iterations."""
        self.solves += 1
        method = self.methods[sheet]
        return method.follow(self.parameters(place), method.space.decode(start.point), start.cost, BARRIER, limit)

    def cost_at(self, sheet: int, place: Place, start: Prediction, limit: int) -> float | None:
        """The problem's cost of the motion that a start leads to; None where it leads to none that passes the check."""
        found = self.refined(sheet, place, start, limit)
        return found.cost if self._is_solution(sheet, place, found) else None

    def _all(self, method: str, requests: Sequence[Request], *further: int) -> list[Any]:
        if self._each is None or len(requests) < 2:
            return [getattr(self, method)(*request, *further) for request in requests]
        self.solves += len(requests)
        return self._each(method, [(self.patterns[sheet], (*where, *further)) for sheet, *where in requests])

    def from_solution(self, sheet: int, w: Array, bounds: Array, rows: Array, cost: float) -> Prediction:
        """A start from a solved w [nw], its multipliers (bounds [nw], rows [ng]; CasADi's signs) and its cost."""
        space = self.methods[sheet].space
        point = space.split(w, bounds, rows, cost)
        # A multiplier of 0 has no logarithm. What it is on the path `centre` finds out.
        tiny = BARRIER * 1e-3
        lower, upper = np.maximum(point.lower, tiny), np.maximum(point.upper, tiny)
        return Prediction(cost, space.encode(Point(point.free, point.rows, lower, upper)))

    def parameters(self, place: Place) -> Array:
        """What the problem takes: a value for every axis."""
        return self._space.task(dict(zip(self._space.ranged, place, strict=True))).parameters

    def _tangents(self, method: InteriorPoint, task: Array, point: Point, cost: float, slopes: Array) -> Array:
        """Derivatives [a, ny] of the point for a cost divided by its optimum, which changes with the task as well."""
        at_fixed_unit = method.tangent(task, point, cost, BARRIER)[self._columns]
        other = method.centre(task, _rescaled(point, 1 / OTHER_UNIT), OTHER_UNIT * cost, BARRIER, ITERATIONS)
        if not other.converged:
            return at_fixed_unit
        with_unit = (method.space.encode(other.point) - method.space.encode(point)) / np.log(OTHER_UNIT)
        tangents: Array = at_fixed_unit + slopes[:, None] * with_unit
        return tangents

    def _is_solution(self, sheet: int, place: Place, optimum: Outcome) -> bool:
        if not (optimum.converged and optimum.cost > 0):
            return False
        task = self._space.task(dict(zip(self._space.ranged, place, strict=True)))
        trajectory = self.problem.layout.unpack(optimum.w, task.cycle_duration)
        return check.worst(self._scenario, trajectory, task, self.patterns[sheet].text) <= check.FEASIBLE


def _lagrangian_slopes(nlp: ca.Function, columns: Sequence[int]) -> ca.Function:
    """(w, task, multipliers of the rows) -> derivatives [a] of the optimal cost: bounds do not depend on the task."""
    w, task = ca.SX.sym("w", nlp.numel_in(0)), ca.SX.sym("task", nlp.numel_in(1))
    multipliers = ca.SX.sym("multipliers", nlp.numel_out(1))
    cost, rows = nlp(w, task)
    slopes = ca.gradient(cost + ca.dot(multipliers, rows), task)
    return ca.Function("slopes", [w, task, multipliers], [ca.vertcat(*(slopes[i] for i in columns))])


def _rescaled(point: Point, factor: float) -> Point:
    """The point for another unit of the cost."""
    return Point(point.free, point.rows * factor, point.lower * factor, point.upper * factor)


def _finite(*arrays: Array) -> bool:
    return all(bool(np.isfinite(array).all()) for array in arrays)
