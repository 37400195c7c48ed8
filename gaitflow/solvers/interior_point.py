"""Newton's method along the central path of a gait's problem: what solves maps offline and plans online.

On the central path every bound pushes back by barrier / distance. There the solution moves smoothly with the task, also
where bounds become active, so it can be predicted. Its multipliers say which bounds are likely to become active. From a
good prediction a few Newton steps with a falling barrier reach the optimum. From far off, without any multipliers, it
takes about twenty. There is no line search: what does not converge goes to IPOPT.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.solvers.kkt import Kkt, NotFactorised
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program

ROWS = 5e-7  # largest error of a row, half of what the check allows, which has the last word
COST = 1e-5  # what the rows' errors change the cost by, at their multipliers, the cost being about 1
DUAL = 1e-5  # largest error of the gradient, the cost being about 1
GAP = 3e-6  # complementarity that a run heads for, over all bounds, relative to the cost
CENTRED = 0.01  # relative deviation from the central path that `centre` leaves
LARGEST_ROW = 1e4  # a row further off than this is a lost run
NEAREST = 1e-15  # of a distance to a bound, which rounding may make 0
NEAR = 1e-2  # errors below which the barrier may fall
LEAST_STIFFNESS = 1e-14
HELD = 1e-3  # on H's diagonal once only rows are off: where the cost is flat nothing else holds a motion in place
SHORT = 0.3  # a step shorter than this leads nowhere near a minimum, and the next one is corrected
# Multipliers of rows without a solution grow without end. Over the cost, those of solved gaits stay below 100 (two in a
# hundred: 1000); where IPOPT found no motion either they are beyond this after 12 to 25 iterations.
LARGEST_MULTIPLIER = 2e3
# A row that large multipliers leave this far off. Near its longest stride a gait that has a motion is some 1e-3 off
# then; of patterns without a motion 95 in a hundred were more than 0.08 off in space, 0.16 in the plane.
UNMET = 2e-2
# Rows that are nearly met are given up only where multipliers go beyond those of such gaits, 3e5 at most. Just beyond
# the longest stride, where there is no motion, they do within 15 iterations.
LARGEST_OF_ALL, NEARLY_MET = 5e5, 5e-4
EARLY = 10  # iterations in which multipliers only find their size

Ending = Literal["converged", "infeasible", "lost", "limit"]


@dataclass(frozen=True)
class Outcome:
    """What a run came to: `cost` is the program's, `gap` the complementarity left, relative to the cost's unit.

    ending: "infeasible" where rows are far from met and their multipliers say that they cannot be met, which is
    evidence from one start and no proof; "lost" where numbers or the matrix gave out; "limit" of iterations.
    """

    ending: Ending
    iterations: int
    w: Array  # [nw]
    point: Point
    cost: float
    gap: float

    @property
    def converged(self) -> bool:
        """Whether this is an optimum, or for `centre` a point of the central path."""
        return self.ending == "converged"


@dataclass(frozen=True)
class _Residual:
    to_lower: Array  # distances [nF + nI] to the bounds, 1 where there is none
    to_upper: Array
    slope: Array  # [nF + nI] of the Lagrangian without the bounds' part
    pushes: Array  # [nF + nI] that part
    rows: Array  # [nE + nI]
    products: Array  # complementarity of every bound
    cost: float  # to first order what it would change by, were the rows met; over its unit

    @property
    def dual(self) -> float:
        return float(np.abs(self.slope - self.pushes).max())

    @property
    def row(self) -> float:
        return float(np.abs(self.rows).max())

    @property
    def largest(self) -> float:
        return max(self.row, self.dual)

    @property
    def lost(self) -> bool:
        return not np.isfinite(self.row + self.dual) or self.row > LARGEST_ROW

    @property
    def optimal(self) -> bool:
        """Nothing but rows is left to be done."""
        return self.dual <= DUAL and bool(self.products.sum() <= 3 * GAP)

    def within(self, barrier: float | None) -> bool:
        """A solution, or with a barrier: on the central path at it."""
        if self.row > ROWS or self.cost > COST:
            return False
        if barrier is None:
            return self.optimal
        return self.dual <= DUAL and bool(np.abs(self.products - barrier).max() <= CENTRED * barrier)


class InteriorPoint:
    """The problem of one gait, in that gait's `space`. For one thread."""

    def __init__(self, program: Program, space: GaitSpace) -> None:
        self._program = program
        self.space = space
        self._kkt = Kkt(program, space)
        self._w = space.fixed.copy()
        self._multipliers = np.zeros(program.row_count)

    def follow(
        self, task: Array, start: Point, unit: float, barrier: float, limit: int, careful: bool = False
    ) -> Outcome:
        """To the optimum at a task [axes], from a point near the central path at `barrier`; `limit` iterations at most.

        unit > 0 is about the cost at the optimum; the start's multipliers belong to cost / unit. `careful`: every step
        is taken with a matrix of the right inertia, which from far off leads to better optima and more often to one.
        """
        return self._run(task, start, unit, barrier, GAP / self.space.bounds, limit, careful)

    def centre(self, task: Array, start: Point, unit: float, barrier: float, limit: int) -> Outcome:
        """To the point of the central path at `barrier`; as `follow` otherwise."""
        return self._run(task, start, unit, barrier, barrier, limit, careful=False)

    def tangent(self, task: Array, point: Point, unit: float, barrier: float) -> Array:
        """How the encoded point of the central path at `barrier` changes with every axis of the task [axes, ny].

        `point` is that point at a task [axes]. Raises NotFactorised.
        """
        space, free, slacks = self.space, len(self.space.free), len(self.space.free) + len(self.space.equal)
        self._evaluate(point.free, point.rows, task, unit)
        gradient, rows = self._program.by_task(self._w, task, self._multipliers)
        right = -np.vstack([gradient[space.free] / unit, rows[space.equal], rows[space.unequal]])
        # On the central path a bound's distance is barrier / multiplier, more exactly than by a subtraction.
        per_lower, per_upper = point.lower / barrier, point.upper / barrier
        stiffness = point.lower * per_lower + point.upper * per_upper
        stiff = stiffness[free:] + LEAST_STIFFNESS
        self._kkt.factorise(unit, stiffness[:free], 1 / stiff)
        tangents = []
        for each in right.T:
            step = self._kkt.solve(each) if each.any() else np.zeros(free + space.rows)
            moved = np.concatenate([step[:free], step[slacks:] / stiff])
            pushes = [-(per_lower * moved)[space.has_lower], (per_upper * moved)[space.has_upper]]
            tangents.append(np.concatenate([step, *pushes]))
        return np.array(tangents)

    def _run(
        self, task: Array, start: Point, unit: float, barrier: float, end: float, limit: int, careful: bool
    ) -> Outcome:
        centring, length = end == barrier, 1.0
        ending: Ending | None = None
        self._kkt.last_lift = 0.0
        with np.errstate(all="ignore"):  # a lost run ends at a number that is not finite
            values, point = self._inside(task, start, barrier)
            self._evaluate(values, point.rows, task, unit)
            for iteration in range(limit + 1):
                residual = self._residual(values, point, unit)
                ending = self._ending(residual, point, unit, end if centring else None, iteration)
                if ending is not None or iteration == limit:
                    break
                if iteration == 0 or residual.largest < NEAR:
                    barrier = max(end, min(0.1 * barrier, barrier**1.5))
                correct = careful or length < SHORT
                try:
                    values, point, length = self._step(values, point, residual, unit, barrier, correct)
                except NotFactorised:
                    ending = "lost"
                    break
                self._evaluate(values, point.rows, task, unit)
        cost, gap = float(self._program.cost[0]), float(residual.products.sum())
        return Outcome(ending or "limit", iteration, self._w.copy(), point, cost, gap)

    def _ending(
        self, residual: _Residual, point: Point, unit: float, barrier: float | None, iteration: int
    ) -> Ending | None:
        """Why to stop here; None to go on."""
        if residual.within(barrier):
            return "converged"
        if residual.lost:
            return "lost"
        scale = max(1.0, abs(float(self._program.cost[0])) / unit)
        if iteration >= EARLY and residual.row > NEARLY_MET:
            most = LARGEST_MULTIPLIER if residual.row > UNMET else LARGEST_OF_ALL
            return "infeasible" if np.abs(point.rows).max() > most * scale else None
        return None

    def _residual(self, values: Array, point: Point, unit: float) -> _Residual:
        """How far a point is from the optimality conditions, by the program's last evaluation."""
        program, space, free = self._program, self.space, len(self.space.free)
        below, above = space.has_lower, space.has_upper
        to_lower = np.where(below, np.maximum(values - space.least, NEAREST), 1.0)
        to_upper = np.where(above, np.maximum(space.most - values, NEAREST), 1.0)
        gradient = program.gradient[space.free] / unit + self._kkt.transposed_jacobian(point.rows)
        equal = program.rows[space.equal] - space.equal_to
        rows = np.concatenate([equal, program.rows[space.unequal] - values[free:]])
        return _Residual(
            to_lower=to_lower,
            to_upper=to_upper,
            slope=np.concatenate([gradient, -point.rows[len(space.equal) :]]),
            pushes=point.lower - point.upper,
            rows=rows,
            products=np.concatenate([(point.lower * to_lower)[below], (point.upper * to_upper)[above]]),
            cost=abs(float(rows @ point.rows)),
        )

    def _step(
        self, values: Array, point: Point, residual: _Residual, unit: float, barrier: float, correct: bool
    ) -> tuple[Array, Point, float]:
        """One Newton step towards the central path at `barrier`, shortened to stay inside, and how short it became.

        `correct` looks after the matrix's eigenvalues. Raises NotFactorised.
        """
        space, free, slacks = self.space, len(self.space.free), len(self.space.free) + len(self.space.equal)
        below, above, to_lower, to_upper = space.has_lower, space.has_upper, residual.to_lower, residual.to_upper
        stiffness = point.lower / to_lower * below + point.upper / to_upper * above
        force = residual.slope - barrier * (below / to_lower - above / to_upper)
        stiff = stiffness[free:] + LEAST_STIFFNESS
        right = -np.concatenate([force[:free], residual.rows])
        right[slacks:] -= force[free:] / stiff
        hold = HELD if residual.optimal else 0.0
        self._kkt.factorise(unit, stiffness[:free] + hold, 1 / stiff, correct)
        step = self._kkt.solve(right)
        moved = np.concatenate([step[:free], (step[slacks:] - force[free:]) / stiff])
        lower = np.where(below, (barrier - point.lower * moved) / to_lower - point.lower, 0.0)
        upper = np.where(above, (barrier + point.upper * moved) / to_upper - point.upper, 0.0)
        keep = max(0.99, 1 - barrier)
        primal = min(_longest(to_lower, moved, below, keep), _longest(to_upper, -moved, above, keep))
        dual = min(_longest(point.lower, lower, below, keep), _longest(point.upper, upper, above, keep))
        values = values + primal * moved
        rows = point.rows + primal * step[free:]
        point = Point(values[:free], rows, point.lower + dual * lower, point.upper + dual * upper)
        return values, point, min(primal, dual)

    def _inside(self, task: Array, start: Point, barrier: float) -> tuple[Array, Point]:
        """Values [nF + nI] of free variables and inequality rows inside their bounds, and multipliers that fit."""
        space = self.space
        below, above = space.has_lower, space.has_upper
        self._w[space.free] = start.free
        self._program.evaluate_rows(self._w, task)
        values = np.concatenate([start.free, self._program.rows[space.unequal]])
        width = np.where(below & above, space.most - space.least, np.inf)
        least, most = np.where(below, space.least, 0.0), np.where(above, space.most, 0.0)
        nearest = 0.2 * np.minimum(barrier / np.maximum(start.lower, barrier), 0.1 * width)
        values = np.where(below, np.maximum(values, least + nearest), values)
        nearest = 0.2 * np.minimum(barrier / np.maximum(start.upper, barrier), 0.1 * width)
        values = np.where(above, np.minimum(values, most - nearest), values)
        to_lower, to_upper = np.where(below, values - least, 1.0), np.where(above, most - values, 1.0)
        lower = np.clip(start.lower, 0.1 * barrier / to_lower, 10 * barrier / to_lower)
        upper = np.clip(start.upper, 0.1 * barrier / to_upper, 10 * barrier / to_upper)
        return values, Point(values[: len(space.free)], start.rows, lower * below, upper * above)

    def _evaluate(self, values: Array, rows: Array, task: Array, unit: float) -> None:
        space = self.space
        self._w[space.free] = values[: len(space.free)]
        self._multipliers[space.equal], self._multipliers[space.unequal] = np.split(rows * unit, [len(space.equal)])
        self._program.evaluate(self._w, task, self._multipliers)


def _longest(distance: Array, step: Array, where: NDArray[np.bool_], keep: float) -> float:
    """The longest step, at most 1, that leaves 1 - keep of every distance."""
    shrinking = where & (step < 0)
    return min(1.0, float((-keep * distance[shrinking] / step[shrinking]).min(initial=np.inf)))
