"""The orientation between knots: angles as cubics through the knots' angles and rates, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.core.rigid_body import Attitude
from gaitflow.core.trajectory import Array


@dataclass(frozen=True, eq=False)
class Turning:
    """Angles [K + 1, a] rad with their rates [K + 1, a] rad/s at times [K + 1] s; cubic in each step, smooth at knots.

    a is 1 in the plane (pitch, nose up) and 3 in space (yaw, pitch, roll).
    """

    times: Array
    angles: Array
    rates: Array

    def at(self, since: Array) -> tuple[Array, Array, Array]:
        """Angles, their first and their second derivatives [n, a] at times [n] s of the cycle."""
        step = np.searchsorted(self.times[1:-1], since, side="right")
        h = (self.times[step + 1] - self.times[step])[:, None]
        s = (since - self.times[step])[:, None] / h
        before, leaving, arriving = self.angles[step], h * self.rates[step], h * self.rates[step + 1]
        way = self.angles[step + 1] - before
        square, cube = 3 * way - 2 * leaving - arriving, leaving + arriving - 2 * way
        return (
            before + s * (leaving + s * (square + s * cube)),
            (leaving + s * (2 * square + s * 3 * cube)) / h,
            (2 * square + s * 6 * cube) / h**2,
        )


def quaternions(angles: Array) -> Array:
    """Unit quaternions (w, x, y, z) [n, 4] from the base to the world for angles [n, a]; continuous in the angles."""
    cos, sin = np.cos(angles / 2).T, np.sin(angles / 2).T
    if len(cos) == 1:  # pitch, nose up: about -y
        return np.stack([cos[0], np.zeros_like(cos[0]), -sin[0], np.zeros_like(cos[0])], axis=-1)
    (cy, cp, cr), (sy, sp, sr) = cos, sin
    return np.stack(
        [
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        ],
        axis=-1,
    )


def angular_velocity(angles: Array, rates: Array) -> Array:
    """In the base frame [n, a] rad/s, for angles and rates [n, a]."""
    if angles.shape[-1] == 1:
        return rates
    (_, sp, sr), (_, cp, cr) = np.sin(angles).T, np.cos(angles).T
    yawing, pitching, rolling = rates.T
    return np.stack(
        [rolling - sp * yawing, cr * pitching + sr * cp * yawing, cr * cp * yawing - sr * pitching], axis=-1
    )


def angular_acceleration(angles: Array, rates: Array, second: Array) -> Array:
    """d/dt of the angular velocity in the base frame [n, a] rad/s^2; `second` are the angles' second derivatives."""
    if angles.shape[-1] == 1:
        return second
    (_, sp, sr), (_, cp, cr) = np.sin(angles).T, np.cos(angles).T
    yawing, pitching, rolling = rates.T
    along = angular_velocity(angles, second)
    changes = [
        -cp * pitching * yawing,
        -sr * rolling * pitching + (cr * cp * rolling - sr * sp * pitching) * yawing,
        -(sr * cp * rolling + cr * sp * pitching) * yawing - cr * rolling * pitching,
    ]
    return along + np.stack(changes, axis=-1)


def at_base_link(
    centre: Array, turning: tuple[Array, Array, Array], body: tuple[Array, Array, Array]
) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration [n, 3] of the base link's origin, from those of the centre of mass.

    centre [3] m is the centre of mass in the base link's frame; turning: angles [n, 3] and their first and second
    derivatives.
    """
    (angles, rates, second), (position, velocity, acceleration) = turning, body
    attitude, omega = Attitude(angles), angular_velocity(angles, rates)
    moving = np.cross(omega, centre)
    spin = angular_acceleration(angles, rates, second)
    return (
        position - attitude.into_world(np.broadcast_to(centre, omega.shape)),
        velocity - attitude.into_world(moving),
        acceleration - attitude.into_world(np.cross(spin, centre) + np.cross(omega, moving)),
    )
