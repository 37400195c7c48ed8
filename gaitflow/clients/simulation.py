"""A robot in MuJoCo's physics, step by step, under conditions that are not those of its plan."""

from __future__ import annotations

import copy
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.robot_model import FLOOR, PHYSICS_STEP, RobotModel
from gaitflow.core.trajectory import Array


class Push(NamedTuple):
    """A sudden change [3] m/s of the base's velocity in the world, at a time [s]."""

    time: float
    change: tuple[float, float, float]


@dataclass(frozen=True)
class Conditions:
    """What is unlike the plan, and unknown to the controller.

    friction: of the floor, None: the task's. mass_factor: of every link. delay [s]: how late torques act. pushes.
    """

    friction: float | None = None
    mass_factor: float = 1.0
    delay: float = 0.0
    pushes: tuple[Push, ...] = ()

    def __post_init__(self) -> None:
        if self.friction is not None and not 0 < self.friction < np.inf:
            raise ValueError(f"friction = {self.friction:g}: must be positive")
        if not 0 < self.mass_factor < np.inf:
            raise ValueError(f"mass_factor = {self.mass_factor:g}: must be positive")
        if not 0 <= self.delay < 1:
            raise ValueError(f"delay = {self.delay:g} s: must be from 0 to less than 1")


AS_PLANNED = Conditions()


@dataclass(frozen=True, eq=False)
class Measured:
    """The robot's own state at a time [s], as the controller sees it.

    position [7 + joints] and velocity [6 + joints] as MuJoCo has them; touching [legs]: which feet touch the ground.
    """

    time: float
    position: Array
    velocity: Array
    touching: NDArray[np.bool_]


class Simulation:
    """A robot at a state, which `step` moves on by 1 ms."""

    def __init__(self, robot: RobotModel, position: Array, velocity: Array, conditions: Conditions) -> None:
        self.robot = robot
        self._model = copy.copy(robot.physics)
        self._model.body_mass[:] *= conditions.mass_factor
        self._model.body_inertia[:] *= conditions.mass_factor
        if conditions.friction is not None:
            self._model.geom_friction[:, 0] = conditions.friction
        self._data = mujoco.MjData(self._model)
        mujoco.mj_setConst(self._model, self._data)
        self._data.qpos[:], self._data.qvel[:] = position, velocity
        self._late: deque[Array] = deque([np.zeros(self._model.nv - 6)] * round(conditions.delay / PHYSICS_STEP))
        self._pushes = sorted(conditions.pushes)
        self._floor = self._model.geom(FLOOR).id
        self._leg_of = {leg.geom: number for number, leg in enumerate(robot.legs)}
        self.forces = np.zeros((len(robot.legs), 3))
        self.torque = np.zeros(self._model.nv - 6)
        mujoco.mj_forward(self._model, self._data)
        self._read_forces()

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return float(self._data.time)

    @property
    def measured(self) -> Measured:
        """The state now."""
        return Measured(self.time, self._data.qpos.copy(), self._data.qvel.copy(), self.forces[:, 2] > 0)

    @property
    def points(self) -> Array:
        """Where each leg's joints and its foot's ball are [legs, 4, 3] m."""
        joints = [[*self._data.xanchor[leg.velocities - 5], self._data.geom_xpos[leg.geom]] for leg in self.robot.legs]
        return np.array(joints)

    def step(self, torque: Array) -> None:
        """One physics step with torques [joints] N m, which the motors' effort limits cut off.

        Afterwards `torque` is what acted, `forces` [legs, 3] N what the ground exerts on the feet.
        """
        while self._pushes and self._pushes[0].time <= self.time:
            self._data.qvel[:3] += self._pushes.pop(0).change
        self._late.append(np.clip(torque, -self.robot.effort, self.robot.effort))
        self.torque = self._late.popleft()
        self._data.qfrc_applied[6:] = self.torque
        mujoco.mj_step(self._model, self._data)
        self._read_forces()

    def sliding(self) -> Array:
        """Speed over the ground of the point of each foot that is lowest [legs] m/s, rolling deducted."""
        found = np.zeros(len(self.robot.legs))
        jacobian = np.zeros((3, self._model.nv))
        for number, leg in enumerate(self.robot.legs):
            point = self._data.geom_xpos[leg.geom] - [0.0, 0.0, leg.radius]
            mujoco.mj_jac(self._model, self._data, jacobian, None, point, leg.body)
            found[number] = np.hypot(*(jacobian[:2] @ self._data.qvel))
        return found

    def _read_forces(self) -> None:
        """Contact forces in the world; a contact's frame has the floor's normal first."""
        self.forces = np.zeros((len(self.robot.legs), 3))
        wrench = np.zeros(6)
        for number in range(self._data.ncon):
            contact = self._data.contact[number]
            first, second = contact.geom
            leg = self._leg_of.get(second if first == self._floor else first)
            if leg is not None:
                mujoco.mj_contactForce(self._model, self._data, number, wrench)
                sign = 1.0 if first == self._floor else -1.0
                self.forces[leg] += sign * (contact.frame.reshape(3, 3).T @ wrench[:3])
