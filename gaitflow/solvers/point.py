"""What a gait leaves free of the problem, and its primal-dual points: as vectors, and as numbers to predict."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

LARGEST_LOG = 20.0


@dataclass(frozen=True)
class Multipliers:
    """Lagrange multipliers of the scaled fixed-gait problem: bounds [nw] and rows [ng], CasADi's signs."""

    bounds: Array
    rows: Array


@dataclass(frozen=True)
class Point:
    """A primal-dual point of a gait whose cost is divided by a unit.

    free [nF]: the variables that the gait leaves free; rows [nE + nI]: multipliers of the equality, then of the
    inequality rows; lower, upper [nF + nI]: multipliers, 0 or more, of the bounds below and above of the free variables
    and of the inequality rows, 0 where there is none.
    """

    free: Array
    rows: Array
    lower: Array
    upper: Array


@dataclass(frozen=True)
class GaitSpace:
    """The bounds that impose a gait, variables [nw] and rows [ng]; rows without any bound are none of its rows."""

    lower: Array
    upper: Array
    lower_rows: Array
    upper_rows: Array

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Indices [nF] of the variables that are not fixed."""
        return np.flatnonzero(self.upper > self.lower)

    @cached_property
    def equal(self) -> NDArray[np.intp]:
        """Indices [nE] of the equality rows."""
        return np.flatnonzero(self.lower_rows == self.upper_rows)

    @cached_property
    def unequal(self) -> NDArray[np.intp]:
        """Indices [nI] of the inequality rows."""
        bounded = np.isfinite(self.lower_rows) | np.isfinite(self.upper_rows)
        return np.flatnonzero((self.lower_rows < self.upper_rows) & bounded)

    @cached_property
    def fixed(self) -> Array:
        """The variables [nw] with the fixed ones at their values, 0 elsewhere."""
        return np.where(self.upper > self.lower, 0.0, self.lower)

    @cached_property
    def equal_to(self) -> Array:
        """What the equality rows [nE] have to be."""
        return self.lower_rows[self.equal]

    @cached_property
    def least(self) -> Array:
        """Bounds below [nF + nI] of the free variables and the inequality rows."""
        return np.concatenate([self.lower[self.free], self.lower_rows[self.unequal]])

    @cached_property
    def most(self) -> Array:
        """Bounds above [nF + nI] of the same."""
        return np.concatenate([self.upper[self.free], self.upper_rows[self.unequal]])

    @cached_property
    def has_lower(self) -> NDArray[np.bool_]:
        """Which bounds below are there."""
        return np.isfinite(self.least)

    @cached_property
    def has_upper(self) -> NDArray[np.bool_]:
        """Which bounds above are there."""
        return np.isfinite(self.most)

    @cached_property
    def rows(self) -> int:
        """nE + nI."""
        return len(self.equal) + len(self.unequal)

    @cached_property
    def bounds(self) -> int:
        """How many bounds there are."""
        return int(self.has_lower.sum() + self.has_upper.sum())

    @property
    def size(self) -> int:
        """Length ny of an encoded point."""
        return len(self.free) + self.rows + self.bounds

    def encode(self, point: Point) -> Array:
        """The point as numbers [ny] that change smoothly with the task: multipliers of bounds as logarithms."""
        pushes = np.concatenate([point.lower[self.has_lower], point.upper[self.has_upper]])
        return np.concatenate([point.free, point.rows, np.log(pushes)])

    def decode(self, numbers: Array) -> Point:
        """The inverse of `encode`."""
        ends = np.cumsum([len(self.free), self.rows, int(self.has_lower.sum())])
        free, rows, of_lower, of_upper = np.split(numbers, ends)
        lower, upper = np.zeros(len(self.least)), np.zeros(len(self.most))
        lower[self.has_lower] = np.exp(np.minimum(of_lower, LARGEST_LOG))
        upper[self.has_upper] = np.exp(np.minimum(of_upper, LARGEST_LOG))
        return Point(free, rows, lower, upper)

    def split(self, primal: Array, bounds: Array, rows: Array, unit: float) -> Point:
        """The point of a decision vector [nw] and multipliers (bounds [nw], rows [ng]; CasADi's signs, any cost)."""
        of_rows = np.concatenate([rows[self.equal], rows[self.unequal]]) / unit
        signed = np.concatenate([bounds[self.free], rows[self.unequal]]) / unit
        lower, upper = np.maximum(-signed, 0.0), np.maximum(signed, 0.0)
        return Point(primal[self.free], of_rows, lower * self.has_lower, upper * self.has_upper)

    def join(self, point: Point, unit: float) -> tuple[Array, Array, Array]:
        """The inverse of `split`: decision vector [nw], multipliers of bounds [nw] and rows [ng], CasADi's signs.

        Multipliers of fixed variables are 0: no solver needs them.
        """
        primal, bounds, rows = self.fixed.copy(), np.zeros(len(self.lower)), np.zeros(len(self.lower_rows))
        primal[self.free] = point.free
        bounds[self.free] = (point.upper - point.lower)[: len(self.free)] * unit
        rows[self.equal], rows[self.unequal] = np.split(point.rows * unit, [len(self.equal)])
        return primal, bounds, rows
