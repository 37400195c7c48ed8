"""Frames on the ground: where a motion, or the frame that follows its command, lies in the world."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.core.twist import displacements, headings


@dataclass(frozen=True)
class Place:
    """A frame on the ground: its origin x + i y [m], and its heading [rad] to the left, which counts whole turns.

    In the plane y and the heading are 0.
    """

    origin: complex = 0j
    heading: float = 0.0

    @classmethod
    def commanded(cls, task: Task, time: float) -> Place:
        """The frame that follows a task's twist, at a time [s] since it was at the origin."""
        x, y = displacements(task, np.array(time)).tolist()
        return cls(complex(x, y), float(headings(task, np.array(time))))

    def of(self, other: Place) -> Place:
        """Where another frame is whose place is given in this one."""
        return Place(self.origin + self._turn * other.origin, self.heading + other.heading)

    @property
    def inverse(self) -> Place:
        """The world seen from this frame."""
        return Place(-self.origin / self._turn, -self.heading)

    def points(self, vectors: Array) -> Array:
        """Points [..., d] of this frame in the world."""
        moved = self.directions(vectors)
        moved[..., 0] += self.origin.real
        if vectors.shape[-1] == 3:
            moved[..., 1] += self.origin.imag
        return moved

    def directions(self, vectors: Array) -> Array:
        """Vectors [..., d] of this frame in the directions of the world."""
        turned = vectors.copy()
        if vectors.shape[-1] == 3 and self.heading:
            ground = self._turn * (vectors[..., 0] + 1j * vectors[..., 1])
            turned[..., 0], turned[..., 1] = ground.real, ground.imag
        return turned

    def bodies(self, base: Array) -> Array:
        """Base states [..., nb] of this frame in the world."""
        d = 2 if base.shape[-1] == 6 else 3
        a = base.shape[-1] // 2 - d
        moved = base.copy()
        moved[..., :d] = self.points(base[..., :d])
        moved[..., d + a : 2 * d + a] = self.directions(base[..., d + a : 2 * d + a])
        if d == 3:
            moved[..., d] += self.heading
        return moved

    def orientations(self, quaternions: Array) -> Array:
        """Quaternions (w, x, y, z) [..., 4] from a base to this frame, on to the world."""
        c, s = np.cos(self.heading / 2), np.sin(self.heading / 2)
        w, x, y, z = np.moveaxis(quaternions, -1, 0)
        return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=-1)

    @property
    def _turn(self) -> complex:
        return cmath.exp(1j * self.heading)
