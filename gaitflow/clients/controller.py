"""A whole-body controller: torques with which a robot follows a motion, 500 times a second.

It knows the robot's state and which feet touch. Contact forces are those that steer the body, feet in the air follow
the motion's swings, and footholds are moved as the body is off its path and its speed, so that a push is caught by a
step, a little beyond the capture point.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gaitflow.clients.body_target import BodyGains, body_target, heading, planned_centre
from gaitflow.clients.contact_forces import contact_forces
from gaitflow.clients.dynamics import Dynamics, Equations
from gaitflow.clients.reference import Ahead, Followed, Reference, stance_durations
from gaitflow.clients.robot_model import RobotModel
from gaitflow.clients.simulation import Measured
from gaitflow.clients.swing_feet import SwingFeet
from gaitflow.core.layout import GRAVITY
from gaitflow.core.trajectory import Array

CONTROL_STEP = 2e-3  # s


@dataclass(frozen=True)
class Gains:
    """Of the body; of feet in the air, their position [1/s^2] and velocity [1/s]; of standing ones' slip [1/s].

    farthest_step: how far a foothold may be moved, a metre of the base's height.
    """

    body: BodyGains = field(default_factory=BodyGains)
    foot: float = 900.0
    foot_velocity: float = 60.0
    slip: float = 30.0
    farthest_step: float = 0.3


class Controller:
    """The controller of one robot, following one motion after the other; `follow` may be called at any time."""

    def __init__(self, robot: RobotModel, motion: Followed, time: float = 0.0, gains: Gains | None = None) -> None:
        self._robot, self._gains = robot, gains or Gains()
        self._dynamics = Dynamics(robot)
        self._feet = SwingFeet(np.stack([leg.standing for leg in robot.legs]), motion, time)
        self._catch = np.sqrt(robot.height / GRAVITY)  # s, in which a robot falls e times farther
        self.follow(motion, time)

    def follow(self, motion: Followed, time: float) -> None:
        """Follow another motion from a time [s] on, which should be where the one before is."""
        self._ahead = Ahead(motion, CONTROL_STEP)
        self._gain = 1.0 / -np.expm1(-stance_durations(motion, time) / self._catch)

    def reference(self, time: float) -> Reference:
        """What is followed at a time [s]."""
        return self._ahead.at(time)

    def torque(self, measured: Measured) -> Array:
        """Torques [joints] N m for the next step."""
        robot, gains = self._robot, self._gains
        reference = self._ahead.at(measured.time)
        state = reference.state
        lifted = np.zeros(len(robot.legs), dtype=bool)
        free = self._dynamics.at(measured.position, measured.velocity, lifted)
        shift, yaw = self._step(reference, free), heading(state.orientation)
        feet = self._feet.targets(measured.time, state, measured.touching, free.centres, shift, yaw)
        equations = self._dynamics.at(measured.position, measured.velocity, feet.standing)
        target = body_target(robot, reference, equations, measured, gains.body)
        accelerations = np.where(
            feet.standing[:, None],
            -gains.slip * (equations.jacobian @ measured.velocity),
            feet.accelerations
            + gains.foot * (feet.positions - equations.centres)
            + gains.foot_velocity * (feet.velocities - equations.speeds),
        )
        return contact_forces(robot, equations, feet.standing, accelerations, target, state.forces).torque

    def _step(self, reference: Reference, equations: Equations) -> Array:
        """How far footholds are moved [legs, 3] m.

        A step to the capture point keeps a robot as far off as it is; one beyond it lets the robot fall back, to the
        path at the end of the leg's stance.
        """
        robot = self._robot
        centre, velocity, _ = planned_centre(robot, reference)
        ahead = equations.centre - centre + self._catch * (equations.momentum / robot.mass - velocity)
        steps = self._gain[:, None] * (ahead * [1.0, 1.0, 0.0])
        farthest = self._gains.farthest_step * robot.height
        lengths = np.linalg.norm(steps, axis=1, keepdims=True)
        return np.asarray(steps * np.minimum(1.0, farthest / np.maximum(lengths, 1e-9)))
