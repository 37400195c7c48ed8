"""A rigid body written independently, and simulated by an adaptive method: rotation matrix and angular momentum."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gaitflow.config.robot import Robot
from gaitflow.core.layout import GRAVITY, Layout
from gaitflow.core.trajectory import Array


def random_motion(layout: Layout, robot: Robot, seed: int) -> tuple[Array, Array, Array]:
    """A state [nx] far from upright, and forces and velocities [legs, d] that push and move every foot."""
    rng = np.random.default_rng(seed)
    default = np.array([leg.default_foot for leg in robot.legs])
    base = np.concatenate(
        [
            rng.uniform(-1, 1, layout.dimension),
            rng.uniform(-1, 1, layout.angles),
            rng.uniform(-2, 2, layout.dimension),
            rng.uniform(-3, 3, layout.angles),
        ]
    )
    feet = base[: layout.dimension] + default + rng.uniform(-0.2, 0.2, default.shape)
    forces = rng.uniform(-0.3, 0.3, default.shape) * layout.weight
    return np.append(base, feet), forces, rng.uniform(-2, 2, default.shape)


def simulated(
    robot: Robot, slope: float, x: Array, forces: Array, end_forces: Array, speeds: Array, h: float, time: float
) -> Array:
    """The state [nx] after `time` (or before, if negative) of a step of h seconds that begins in the state x.

    Forces [legs, d] run linearly from one to the other in h, feet move at `speeds`. The ground is inclined by `slope`
    [deg]. Computed in the level world, gravity along -z, where the plane is x and z and nose up is about -y.
    """
    d, legs = robot.dimension, len(robot.legs)
    a = 1 if d == 2 else 3
    tilted = Rotation.from_euler("y", -np.radians(slope)).as_matrix()  # the ground's x axis points uphill
    lift = tilted @ (np.eye(3)[:, [0, 2]] if d == 2 else np.eye(3))
    inertia = np.diag([1.0, robot.inertia[0][0], 1.0]) if d == 2 else np.array(robot.inertia)
    angles = np.array([0.0, -x[2], 0.0]) if d == 2 else x[3:6]
    rates = np.array([0.0, -x[5], 0.0]) if d == 2 else x[9:12]
    feet = x[2 * (d + a) :].reshape(legs, d)

    def rate(t: float, y: Array) -> Array:
        position, rotation, velocity, momentum = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:]
        pushes = (forces + t / h * (end_forces - forces)) @ lift.T
        spin = rotation @ np.linalg.solve(inertia, rotation.T @ momentum)
        return np.concatenate(
            [
                velocity,
                np.cross(spin, rotation, axisb=0).T.ravel(),
                pushes.sum(axis=0) / robot.mass - GRAVITY * np.array([0.0, 0.0, 1.0]),
                np.cross((feet + t * speeds) @ lift.T - position, pushes).sum(axis=0),
            ]
        )

    to_world = tilted @ Rotation.from_euler("ZYX", angles).as_matrix()
    velocity = x[d + a : 2 * d + a]
    start = np.concatenate([lift @ x[:d], to_world.ravel(), lift @ velocity, to_world @ inertia @ rates])
    end = solve_ivp(rate, (0.0, time), start, rtol=1e-11, atol=1e-12).y[:, -1] if time else start
    rotation = end[3:12].reshape(3, 3)
    yaw_pitch_roll = Rotation.from_matrix(tilted.T @ rotation).as_euler("ZYX")
    spin = np.linalg.solve(inertia, rotation.T @ end[15:])
    turned, spun = (-yaw_pitch_roll[[1]], -spin[[1]]) if d == 2 else (yaw_pitch_roll, spin)
    return np.concatenate([lift.T @ end[:3], turned, lift.T @ end[12:15], spun, (feet + time * speeds).ravel()])
