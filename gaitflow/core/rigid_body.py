"""Eq. (4) and (5) a second time, in numpy and for many states at once: the mechanics that the check uses.

It is written without the transcription's code, and with other formulas where there are any, so that both do not share a
mistake. Arrays have any leading axes; the plane's vectors are (x, z), its one angle turns x to z.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array

G = 9.81  # m/s^2


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A robot's body at a task.

    mass [kg], with what it carries; weight [N] of the robot alone on the level, the scale of forces; inertia and its
    inverse [a, a] kg m^2 in the base frame; gravity [d] m/s^2 in the terrain frame; default_feet [legs, d] m and
    box [d] m of eq. (5).
    """

    dimension: int
    mass: float
    weight: float
    inertia: Array
    inverse: Array
    gravity: Array
    default_feet: Array
    box: Array

    @classmethod
    def of(cls, robot: Mapping[str, Any], task: Task) -> RigidBody:
        """The body of a robot's JSON data, on a task's ground."""
        d, angle = int(robot["dimension"]), math.radians(task["slope"])
        inertia = np.array(robot["inertia"], dtype=float)
        gravity = np.zeros(d)
        gravity[0], gravity[-1] = -G * math.sin(angle), -G * math.cos(angle)
        return cls(
            dimension=d,
            mass=float(robot["mass"]) + task["payload"],
            weight=float(robot["mass"]) * G,
            inertia=inertia,
            inverse=np.linalg.inv(inertia),
            gravity=gravity,
            default_feet=np.array([leg["default_foot"] for leg in robot["legs"]], dtype=float),
            box=np.array(robot["box"], dtype=float),
        )

    @property
    def angles(self) -> int:
        """Number of angles a."""
        return len(self.inertia)

    def split(self, base: Array) -> tuple[Array, Array, Array, Array]:
        """Position, angles, velocity and angular velocity of base states [..., nb]."""
        d, a = self.dimension, self.angles
        return base[..., :d], base[..., d : d + a], base[..., d + a : 2 * d + a], base[..., 2 * d + a :]

    def acceleration(self, forces: Array) -> Array:
        """Of the centre of mass [..., d] under forces [..., legs, d]."""
        moved: Array = forces.sum(axis=-2) / self.mass + self.gravity
        return moved

    def spin(self, base: Array, feet: Array, forces: Array, attitude: Attitude) -> Array:
        """Angular acceleration [..., a] in the base frame."""
        torque = moment(feet - base[..., None, : self.dimension], forces).sum(axis=-2)
        if self.dimension == 2:
            return torque * self.inverse[0, 0]
        omega = base[..., 9:]
        gained: Array = attitude.into_base(torque) - moment(omega, omega @ self.inertia)
        return gained @ self.inverse

    def rate(self, base: Array, feet: Array, forces: Array) -> Array:
        """d/dt of base states [..., nb]."""
        _, angles, velocity, omega = self.split(base)
        attitude = Attitude(angles)
        return np.concatenate(
            [
                velocity,
                attitude.rates(omega),
                self.acceleration(forces),
                self.spin(base, feet, forces, attitude),
            ],
            axis=-1,
        )

    def angular_momentum(self, base: Array) -> Array:
        """About the world's origin, in world directions [..., a] kg m^2/s."""
        position, angles, velocity, omega = self.split(base)
        own = omega @ self.inertia
        if self.dimension == 3:
            own = Attitude(angles).into_world(own)
        return own + self.mass * moment(position, velocity)

    def box_excess(self, position: Array, angles: Array, feet: Array) -> Array:
        """How far feet [..., legs, d] are outside of their boxes [..., legs, d] m, negative inside; eq. (5)."""
        offsets = Attitude(angles).into_base(feet - position[..., None, :]) - self.default_feet
        return np.abs(offsets) - self.box


class Attitude:
    """Orientations of the base: angles [..., 1] (pitch, nose up) or [..., 3] (yaw, pitch, roll; R = Rz Ry Rx)."""

    def __init__(self, angles: Array) -> None:
        self._planar = angles.shape[-1] == 1
        self._cos, self._sin = np.cos(angles), np.sin(angles)

    def into_base(self, vectors: Array) -> Array:
        """World vectors [..., d], or [..., n, d] with one orientation for n of them, in the base frame."""
        cos, sin = self._like(vectors)
        if self._planar:
            x, z = vectors[..., 0], vectors[..., 1]
            c, s = cos[..., 0], sin[..., 0]
            return _stack(c * x + s * z, c * z - s * x)
        x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
        x, y = cos[..., 0] * x + sin[..., 0] * y, cos[..., 0] * y - sin[..., 0] * x
        x, z = cos[..., 1] * x - sin[..., 1] * z, cos[..., 1] * z + sin[..., 1] * x
        y, z = cos[..., 2] * y + sin[..., 2] * z, cos[..., 2] * z - sin[..., 2] * y
        return _stack(x, y, z)

    def into_world(self, vectors: Array) -> Array:
        """Base vectors [..., 3] in world directions; in space only."""
        cos, sin = self._like(vectors)
        x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
        y, z = cos[..., 2] * y - sin[..., 2] * z, cos[..., 2] * z + sin[..., 2] * y
        x, z = cos[..., 1] * x + sin[..., 1] * z, cos[..., 1] * z - sin[..., 1] * x
        x, y = cos[..., 0] * x - sin[..., 0] * y, cos[..., 0] * y + sin[..., 0] * x
        return _stack(x, y, z)

    def rates(self, omega: Array) -> Array:
        """d/dt of the angles for angular velocities [..., a] in the base frame."""
        if self._planar:
            return omega
        across, pitching = self._yawing(omega)
        yawing = across / self._cos[..., 1]
        return _stack(yawing, pitching, omega[..., 0] + self._sin[..., 1] * yawing)

    def accelerations(self, omega: Array, spin: Array) -> Array:
        """d^2/dt^2 of the angles, for angular velocities and accelerations [..., a] in the base frame."""
        if self._planar:
            return spin
        rates = self.rates(omega)
        yawing, pitching, rolling = rates[..., 0], rates[..., 1], rates[..., 2]
        cos, sin = self._cos[..., 1], self._sin[..., 1]
        across, down = self._yawing(spin)
        pitched = down - rolling * cos * yawing
        yawed = (across + rolling * pitching + yawing * pitching * sin) / cos
        return _stack(yawed, pitched, spin[..., 0] + pitching * cos * yawing + sin * yawed)

    def _yawing(self, vector: Array) -> tuple[Array, Array]:
        """A base vector's components along the yaw axis seen level, and along the pitch axis."""
        c, s = self._cos[..., 2], self._sin[..., 2]
        return s * vector[..., 1] + c * vector[..., 2], c * vector[..., 1] - s * vector[..., 2]

    def _like(self, vectors: Array) -> tuple[Array, Array]:
        if vectors.ndim > self._cos.ndim:
            return self._cos[..., None, :], self._sin[..., None, :]
        return self._cos, self._sin


def moment(lever: Array, force: Array) -> Array:
    """lever x force [..., a]; in the plane positive from x to z."""
    if lever.shape[-1] == 2:
        turning: Array = lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0]
        return turning[..., None]
    a, b, c = lever[..., 0], lever[..., 1], lever[..., 2]
    x, y, z = force[..., 0], force[..., 1], force[..., 2]
    return _stack(b * z - c * y, c * x - a * z, a * y - b * x)


def _stack(*components: Array) -> Array:
    out = np.empty((*np.broadcast_shapes(*(part.shape for part in components)), len(components)))
    for i, part in enumerate(components):
        out[..., i] = part
    return out
