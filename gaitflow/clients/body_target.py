"""What a robot's body should do next so that it follows its plan's: the force on it, and how its base turns.

The force steers the centre of mass of all links together, as in the plan, because only the ground's forces move it. The
base itself turns as planned. If it could recoil from swinging legs it would roll, and standing legs would have to
follow it, which costs ANYmal up to a sixth of its energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.clients.dynamics import Equations
from gaitflow.clients.reference import Reference
from gaitflow.clients.robot_model import RobotModel
from gaitflow.clients.rotation import rotation_of
from gaitflow.clients.simulation import Measured
from gaitflow.core.trajectory import Array


@dataclass(frozen=True)
class BodyGains:
    """Of the centre of mass' position [1/s^2] and velocity [1/s], the orientation [1/s^2] and the spin [1/s].

    farthest [m]: positions farther off than that are walked off, not pulled off.
    """

    position: float = 50.0
    velocity: float = 12.0
    orientation: float = 100.0
    spin: float = 20.0
    farthest: float = 0.05


@dataclass(frozen=True, eq=False)
class BodyTarget:
    """Force of the ground on the robot [3] N, in the world, and angular acceleration of its base [3] rad/s^2, in it."""

    force: Array
    angular_acceleration: Array


def body_target(
    robot: RobotModel, reference: Reference, equations: Equations, measured: Measured, gains: BodyGains
) -> BodyTarget:
    """What the body should do in a measured state."""
    state = reference.state
    centre, velocity, acceleration = planned_centre(robot, reference)
    off = np.clip(centre - equations.centre, -gains.farthest, gains.farthest)
    slower = velocity - equations.momentum / robot.mass
    force = robot.mass * (acceleration - robot.gravity + gains.position * off + gains.velocity * slower)
    turned = rotation_between(measured.position[3:7], state.orientation)
    slack = state.angular_velocity - measured.velocity[3:6]
    return BodyTarget(force, reference.angular_acceleration + gains.orientation * turned + gains.spin * slack)


def planned_centre(robot: RobotModel, reference: Reference) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration [3] of the centre of mass where the reference has the base link.

    It is where it is in the standing pose, as in the plan.
    """
    state = reference.state
    planned = rotation_of(state.orientation)
    arm, spin, gained = (
        planned @ vector for vector in (robot.centre, state.angular_velocity, reference.angular_acceleration)
    )
    turning = np.cross(gained, arm) + np.cross(spin, np.cross(spin, arm))
    return state.position + arm, state.velocity + np.cross(spin, arm), state.acceleration + turning


def rotation_between(first: Array, last: Array) -> Array:
    """The rotation vector [3] rad, in the first frame, from one orientation (w, x, y, z) to another one."""
    w1, v1, w2, v2 = first[0], first[1:], last[0], last[1:]
    real = w1 * w2 + v1 @ v2
    imaginary = w1 * v2 - w2 * v1 - np.cross(v1, v2)
    sign = 1.0 if real >= 0 else -1.0
    length = float(np.linalg.norm(imaginary))
    angle = 2.0 * np.arctan2(length, sign * real)
    return np.asarray(sign * imaginary * (angle / length if length > 1e-12 else 2.0))


def heading(orientation: Array) -> float:
    """Where the x axis of a unit quaternion (w, x, y, z) faces over the ground [rad]."""
    w, x, y, z = orientation
    return float(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
