"""Points of the central path without the multipliers that follow from others there.

An encoded point (`GaitSpace.encode`) has a number for each free variable, each row and each bound. On the central path
the multiplier of a bound is the barrier over the distance to it. So between two bounds one multiplier tells the other,
since the distances add up to the width between them, and the multiplier of an inequality row is the difference of those
of its bounds. What is left of a point are its free variables [nF], the multipliers of equality rows [nE], and a number
for each free variable or inequality row that has a bound [nB], which grows from the bound below to the one above:

    -log(lower) with a bound below, log(upper) with one above, log(upper / lower) between two,

with the multipliers lower and upper of the two bounds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.solvers.point import GaitSpace

LARGEST_LOG = 40.0  # of a multiplier, or of one over the other: numbers of a file may be anything


@dataclass(frozen=True)
class Condenser:
    """Condenses and expands points of one pattern's space that are on the central path at `barrier`."""

    space: GaitSpace
    barrier: float

    @property
    def size(self) -> int:
        """How many numbers a condensed point has, nF + nE + nB."""
        return self._plain + int(self._bounded.sum())

    @property
    def kinds(self) -> tuple[int, int, int]:
        """How many of them are variables, multipliers of rows, and of bounds: nF, nE, nB."""
        return len(self.space.free), len(self.space.equal), self.size - self._plain

    def condensed(self, encoded: Array) -> Array:
        """Condensed points or tangents [..., size] of encoded ones [..., ny]: it is linear."""
        space, first = self.space, len(self.space.free) + self.space.rows
        between = first + int(space.has_lower.sum())
        logs = np.zeros((*encoded.shape[:-1], len(space.least)))
        logs[..., space.has_upper] += encoded[..., between:]
        logs[..., space.has_lower] -= encoded[..., first:between]
        return np.concatenate([encoded[..., : self._plain], logs[..., self._bounded]], axis=-1)

    def expanded(self, numbers: Array) -> Array:
        """The encoded point [ny] of a condensed one [size]."""
        space, free = self.space, len(self.space.free)
        logs = np.zeros(len(space.least))
        logs[self._bounded] = np.clip(numbers[self._plain :], -LARGEST_LOG, LARGEST_LOG)
        # With r = upper / lower the distances are width r / (1 + r) and width / (1 + r).
        lower = np.where(self._between, self._least + np.logaddexp(0.0, -logs), -logs)
        upper = np.where(self._between, self._least + np.logaddexp(0.0, logs), logs)
        of_rows = np.where(space.has_upper, np.exp(upper), 0.0) - np.where(space.has_lower, np.exp(lower), 0.0)
        return np.concatenate([numbers[: self._plain], of_rows[free:], lower[space.has_lower], upper[space.has_upper]])

    @property
    def _plain(self) -> int:
        return len(self.space.free) + len(self.space.equal)

    @cached_property
    def _bounded(self) -> NDArray[np.bool_]:
        """Which of the free variables and inequality rows have a bound."""
        return self.space.has_lower | self.space.has_upper

    @cached_property
    def _between(self) -> NDArray[np.bool_]:
        """Which of them have two."""
        return self.space.has_lower & self.space.has_upper

    @cached_property
    def _least(self) -> Array:
        """Logarithms of the least that a multiplier between two bounds may be: the barrier over the width."""
        width = np.where(self._between, self.space.most - self.space.least, 1.0)
        least: Array = np.log(self.barrier / width)
        return least
