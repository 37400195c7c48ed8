"""The equations of motion at a state, with the joints' accelerations expressed by the base's and the feet's."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.robot_model import BASE, RobotModel
from gaitflow.core.trajectory import Array

DAMPING = 1e-6  # m^2, of the inverse of a leg's Jacobian: a straight leg bends in no one direction
REACHED = 1e-6  # m
INVERSE_STEPS = 50


@dataclass(frozen=True, eq=False)
class Equations:
    """M a + h = S^T tau + J^T f: what is needed of it, at one state; v = 6 + joints.

    mass [v, v], bias [v] (Coriolis, gravity, friction in the joints), jacobian [legs, 3, v] of each foot's point and
    drift [legs, 3] m/s^2, its acceleration when a = 0. centres and speeds [legs, 3] are of the balls' centres [m, m/s].
    centre [3] m is the centre of mass of all links, momentum [3] N s is theirs; everything in the world.
    """

    mass: Array
    bias: Array
    jacobian: Array
    drift: Array
    centres: Array
    speeds: Array
    centre: Array
    momentum: Array


class Dynamics:
    """A robot's equations of motion by MuJoCo, without contacts. Holds scratch memory: one a thread."""

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self._model = robot.physics
        self._data = mujoco.MjData(robot.physics)
        self._mass = np.zeros((self._model.nv, self._model.nv))

    def at(self, position: Array, velocity: Array, standing: NDArray[np.bool_]) -> Equations:
        """At positions [7 + joints] and velocities [6 + joints] as MuJoCo has them.

        The point of a foot that stands [legs] bool is where it touches the ground, of another one its ball's centre.
        """
        model, data, robot = self._model, self._data, self.robot
        data.qpos[:] = position
        data.qvel[:] = velocity
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_comVel(model, data)
        bias = np.zeros(model.nv)
        mujoco.mj_rne(model, data, 0, bias)
        mujoco.mj_fullM(model, data, self._mass)
        legs = len(robot.legs)
        jacobian, change = np.zeros((legs, 3, model.nv)), np.zeros((legs, 3, model.nv))
        at_centre = np.zeros((legs, 3, model.nv))
        centres = data.geom_xpos[[leg.geom for leg in robot.legs]].copy()
        points = centres.copy()
        for number, leg in enumerate(robot.legs):
            mujoco.mj_jac(model, data, at_centre[number], None, centres[number], leg.body)
            point = points[number]
            if standing[number]:
                point[2] -= leg.radius
                mujoco.mj_jac(model, data, jacobian[number], None, point, leg.body)
            else:
                jacobian[number] = at_centre[number]
            mujoco.mj_jacDot(model, data, change[number], None, point, leg.body)
        turning = velocity[BASE:]
        momentum, centre = self._mass[:3] @ velocity, data.subtree_com[0].copy()
        bias[BASE:] += model.dof_damping[BASE:] * turning + robot.friction_torque * np.tanh(turning / 0.5)
        return Equations(
            mass=self._mass.copy(),
            bias=bias,
            jacobian=jacobian,
            drift=change @ velocity,
            centres=centres,
            speeds=at_centre @ velocity,
            centre=centre,
            momentum=momentum,
        )

    def centres(self, position: Array) -> Array:
        """Where the feet's balls are [legs, 3] m, at positions [7 + joints]."""
        self._data.qpos[:] = position
        mujoco.mj_kinematics(self._model, self._data)
        return np.array(self._data.geom_xpos[[leg.geom for leg in self.robot.legs]])

    def posed(self, base: Array, centres: Array) -> Array:
        """Positions [7 + joints] with the base at `base` [7] and the feet's balls at `centres` [legs, 3] m.

        Newton's method from the standing pose; where a leg is too short its foot comes as near as it gets.
        """
        position = np.concatenate([base, self.robot.standing])
        for _ in range(INVERSE_STEPS):
            found = self.at(position, np.zeros(self._model.nv), np.zeros(len(self.robot.legs), dtype=bool))
            short = centres - found.centres
            if np.abs(short).max() < REACHED:
                break
            for leg, wanted, jacobian in zip(self.robot.legs, short, found.jacobian, strict=True):
                step = inverse(jacobian[None, :, leg.velocities])[0] @ wanted
                position[leg.velocities + 1] += np.clip(step, -0.3, 0.3)
        return position


def inverse(square: Array) -> Array:
    """Of Jacobians [n, 3, 3] of legs, damped: near a straight leg the step stays small."""
    turned = square.transpose(0, 2, 1)
    damped: Array = turned @ np.linalg.inv(square @ turned + DAMPING * np.eye(3))
    return damped
