"""The quadratic program of one moment: the contact forces that steer the body, and the torques that go with them.

In a leg of three joints, the foot's motion (at rest, or along its swing) and the base's acceleration determine the
acceleration of the joints. So by the equations of motion, M a + h = S^T tau + J^T f, the base's acceleration and all
torques are affine in the contact forces, and only the forces are left to find.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import quadprog
from numpy.typing import NDArray

from gaitflow.clients.body_target import BodyTarget
from gaitflow.clients.dynamics import Equations, inverse
from gaitflow.clients.robot_model import BASE, RobotModel
from gaitflow.core.layout import GRAVITY
from gaitflow.core.trajectory import Array

MOMENT = 1.0  # weight of the moment that turns the body, over the robot's height, against that of a force
LIKENESS = 0.01  # weight of forces that differ from the planned ones
LEAST = 0.05  # of the weight: the normal force that keeps a standing foot on the ground
SIDES = np.array([[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Contact forces [legs, 3] N, 0 in the air, and torques [joints] N m.

    limited: whether all standing legs' torques are within their limits; where that cannot be they are left free.
    """

    forces: Array
    torque: Array
    limited: bool


def contact_forces(
    robot: RobotModel,
    equations: Equations,
    standing: NDArray[np.bool_],
    feet: Array,
    target: BodyTarget,
    planned: Array,
) -> ContactForces:
    """The forces of the feet that stand [legs] with which the body comes nearest to a target.

    They push, lie in the friction pyramid inside the cone, and are drawn to the planned ones [legs, 3] N. feet
    [legs, 3] m/s^2: how the feet's points accelerate.
    """
    stood = np.flatnonzero(standing)
    turning, torques = _affine(robot, equations, feet, stood)
    torque, gain = torques[:, 0], torques[:, 1:]
    forces, limited = np.zeros((len(robot.legs), 3)), True
    if len(stood):
        effect = np.vstack([np.tile(np.eye(3), len(stood)), robot.inertia @ turning[:, 1:]])
        wanted = np.concatenate([target.force, robot.inertia @ (target.angular_acceleration - turning[:, 0])])
        weight = np.repeat([1.0, MOMENT / robot.height**2], 3)
        hessian = effect.T @ (weight[:, None] * effect) + LIKENESS * np.eye(effect.shape[1])
        slope = effect.T @ (weight * wanted) + LIKENESS * planned[stood].ravel()
        cone, least = _pyramids(robot, len(stood))
        # Legs in the air have their swings to follow: beyond their limits, no force of the others can help.
        own = np.concatenate([robot.legs[leg].velocities for leg in stood]) - BASE
        rows = np.vstack([cone, -gain[own], gain[own]])
        limits = np.concatenate([least, torque[own] - robot.effort[own], -torque[own] - robot.effort[own]])
        found, limited = _solved(hessian, slope, rows, limits, len(cone))
        forces[stood] = found.reshape(-1, 3)
        torque = torque + gain @ found
    return ContactForces(forces, torque, limited)


def _affine(robot: RobotModel, equations: Equations, feet: Array, stood: NDArray[np.intp]) -> tuple[Array, Array]:
    """The base's angular acceleration [3, 1 + 3 stood] rad/s^2, in its frame, and torques [joints, 1 + 3 stood].

    First without contact forces, then what a force on each standing foot adds.
    """
    columns = np.stack([leg.velocities for leg in robot.legs])
    jacobian, mass, bias = equations.jacobian, equations.mass, equations.bias
    own = inverse(np.take_along_axis(jacobian, columns[:, None, :], axis=2))
    # The joints' accelerations are by_base @ (the base's) + constant.
    by_base, constant = np.zeros((len(bias) - BASE, BASE)), np.zeros(len(bias) - BASE)
    by_base[columns - BASE] = -own @ jacobian[:, :, :BASE]
    constant[columns - BASE] = (own @ (feet - equations.drift)[:, :, None])[:, :, 0]
    push = jacobian[stood].reshape(3 * len(stood), len(bias)).T
    whole = mass[:BASE, :BASE] + mass[:BASE, BASE:] @ by_base
    right = np.column_stack([-(bias[:BASE] + mass[:BASE, BASE:] @ constant), push[:BASE]])
    base = np.linalg.solve(whole, right)
    torques = (mass[BASE:, :BASE] + mass[BASE:, BASE:] @ by_base) @ base
    torques[:, 0] += mass[BASE:, BASE:] @ constant + bias[BASE:]
    torques[:, 1:] -= push[BASE:]
    return np.asarray(base[3:], dtype=float), np.asarray(torques)


def _pyramids(robot: RobotModel, count: int) -> tuple[Array, Array]:
    """Rows [5 count, 3 count] and the least values [5 count] that they may have, of feet that push and do not slip."""
    sides = np.column_stack([SIDES, np.full(4, robot.friction)])
    least = np.concatenate([[LEAST * robot.mass * GRAVITY], np.zeros(4)])
    return np.kron(np.eye(count), np.vstack([[0.0, 0.0, 1.0], sides])), np.tile(least, count)


def _solved(hessian: Array, slope: Array, rows: Array, least: Array, hard: int) -> tuple[Array, bool]:
    """min 1/2 x H x - slope x, rows x >= least; the first `hard` rows alone where the others cannot be met."""
    finite = np.isfinite(least)
    try:
        return quadprog.solve_qp(hessian, slope, rows[finite].T, least[finite])[0], True
    except ValueError:  # no forces meet all of them
        return quadprog.solve_qp(hessian, slope, rows[:hard].T, least[:hard])[0], False
