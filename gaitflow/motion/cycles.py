"""Where each cycle of a motion lies in the world: the first one, moved again and again by the commanded twist.

Vectors are pairs of complex numbers [..., 2], the ground's x + i y (y = 0 in the plane) and the height, so that turning
about the vertical is a product.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.core.twist import displacements, headings

Pair = NDArray[np.complex128]
Numbers = NDArray[np.int64]


def paired(vectors: Array) -> Pair:
    """Vectors [..., d] as pairs [..., 2]."""
    ground = vectors[..., 0] + (1j * vectors[..., 1] if vectors.shape[-1] == 3 else 0j)
    return np.stack([ground, vectors[..., -1].astype(complex)], axis=-1)


def unpaired(pairs: Pair, dimension: int) -> Array:
    """Pairs [..., 2] as vectors [..., d]."""
    ground, up = pairs[..., 0], pairs[..., 1].real
    return np.stack([ground.real, up] if dimension == 2 else [ground.real, ground.imag, up], axis=-1)


@dataclass(frozen=True, eq=False)
class Places:
    """Where some cycles lie: what is at x, s seconds after a cycle's start, is at origin + turn x + drift s.

    turn is of length 1; drift [m/s] is how much faster the body is than in the first cycle. numbers [c], rising, are
    those of the cycles, and `entries` [3, c, 2] their origin, turn and drift.
    """

    numbers: Numbers
    entries: Pair

    def of(self, numbers: Numbers) -> Pair:
        """Origin, turn and drift [3, n, 2] of cycles [n]."""
        found: Pair = self.entries[:, np.searchsorted(self.numbers, numbers)]
        return found


@dataclass(frozen=True, eq=False)
class Cycles:
    """The repetition of a motion of duration `period` [s], eq. (3) applied once a cycle, forwards and backwards.

    Over a cycle the body is turned by `turn`, displaced by `shift` [m], and before that `gain` [m/s] faster along the
    heading [2].
    """

    period: float
    turn: Pair
    shift: Pair
    gain: Pair

    @classmethod
    def of(cls, task: Task, period: float) -> Cycles:
        """The repetition that a task commands."""
        x, y = displacements(task, np.array(period)).tolist()
        turned = complex(np.exp(1j * float(headings(task, np.array(period)))))
        gain = task["acceleration"] * period
        return cls(period, np.array([turned, 1.0]), np.array([complex(x, y), 0j]), np.array([gain, 0j]))

    def split(self, times: Array) -> tuple[Numbers, Array]:
        """Times [n] s as the number of the cycle and the time since its start, 0 <= s < period."""
        numbers = np.floor(times / self.period)
        since = times - numbers * self.period
        numbers += np.where(since >= self.period, 1.0, np.where(since < 0, -1.0, 0.0))  # where rounding has crossed
        since = np.clip(times - numbers * self.period, 0.0, np.nextafter(self.period, 0.0))
        return numbers.astype(np.int64), since

    def places(self, numbers: Numbers) -> Places:
        """Where cycles [n], the ones before them and two after them lie; the first of all is number 0."""
        known = np.unique(numbers[:, None] + np.arange(-1, 3))
        rows: list[Pair] = []
        for place, number in enumerate(known.tolist()):
            if place and known[place - 1] == number - 1:
                rows.append(self._step @ rows[-1])
            else:
                rows.append(np.linalg.matrix_power(self._step, number))
        every = np.reshape(rows, (-1, 2, 3, 3))
        return Places(known, np.moveaxis(every[..., 1], -1, 0))

    @cached_property
    def _step(self) -> Pair:
        """From the origin, turn and drift of one cycle to those of the next one [2, 3, 3].

        Position and velocity go on where the cycle before ended.
        """
        step = np.zeros((2, 3, 3), dtype=complex)
        step[:, 0] = np.stack([np.ones(2), self.shift, np.full(2, self.period)], axis=-1)
        step[:, 1, 1] = self.turn
        step[:, 2] = np.stack([np.zeros(2), self.turn * self.gain, np.ones(2)], axis=-1)
        return step
