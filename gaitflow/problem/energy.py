"""J4: what moving takes of the joints, their torques squared (heat) and their positive work.

Legs stay massless in the dynamics. *Standing* legs carry the forces, in the pose that the foot's place asks for.
*Swinging* legs carry their own mass along the curve that is followed, not the program's own feet, whose way no other
term sees: so a swing costs what its duration says, and a short one is dear. Theirs are the standing pose's joints.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from gaitflow.config.limbs import Limb
from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Objective
from gaitflow.core.layout import GRAVITY
from gaitflow.core.trajectory import Array
from gaitflow.problem.dynamics import Node
from gaitflow.problem.limb import LegPose
from gaitflow.problem.orientation import world_to_base
from gaitflow.problem.task import TaskParameters

SMOOTH_POWER = 0.1  # W/kg: a hundredth of what lifting the robot at 1 m/s takes
SWING_POINTS = 48  # of each half of a swing: its work has corners, where power changes its sign


class JointCost:
    """Weighted heat and work of a robot's joints, by their torques and rates; see `Objective`."""

    def __init__(self, robot: Robot, objective: Objective) -> None:
        self._limbs = robot.limbs or ()
        self._feet = [leg.default_foot for leg in robot.legs]
        self._objective = objective
        self._smallest = SMOOTH_POWER * robot.mass
        self._standing = [
            _standing(limb, ca.SX(ca.DM(list(leg.default_foot))))
            for limb, leg in zip(self._limbs, robot.legs, strict=True)
        ]

    def standing(self, node: Node) -> ca.SX:
        """Of the legs that push, per second: feet with forces are at rest."""
        into_base = world_to_base(node.angles)
        passing = into_base @ node.velocity
        total = ca.SX(0)
        for limb, foot, force in zip(self._limbs, node.feet, node.forces, strict=True):
            place = into_base @ (foot - node.position)
            pose = LegPose(limb, place)
            rates = pose.rates(-passing - ca.cross(node.omega, place))
            total += self._per_second(-pose.torques(into_base @ force), rates)
        return total

    def swing(self, leg: int, task: TaskParameters, duration: ca.SX, apex: float) -> ca.SX:
        """Of a leg's one swing of a duration [s]: the curve that is followed, see `gaitflow.motion.swing`.

        Over the ground a minimum-jerk line as long as a cycle's way, in height such a piece up to `apex` [m] and one
        down, against the leg's place in a body that moves as commanded; and the leg's mass lifted by half the apex.
        """
        cycle, passing = task["cycle_duration"], task.passing(self._feet[leg])
        rates, torques = self._standing[leg]
        cost = ca.SX(self._objective.joint_work * self._limbs[leg].mass * GRAVITY * apex / 2)
        for part, weight in zip(*_gauss(SWING_POINTS), strict=True):
            (pace, gain), (climb, push) = _minimum_jerk(part), _minimum_jerk(2 * part % 1)
            sign = 1 if part < 0.5 else -1
            velocity = (passing * cycle * pace + ca.vertcat(0, 0, 2 * sign * apex * climb)) / duration - passing
            acceleration = (passing * cycle * gain + ca.vertcat(0, 0, 4 * sign * apex * push)) / duration**2
            cost += weight * duration * self._per_second(torques @ acceleration, rates @ velocity)
        return cost

    def _per_second(self, torques: ca.SX, rates: ca.SX) -> ca.SX:
        heat = self._objective.joint_heat * ca.sumsqr(torques)
        if not self._objective.joint_work:
            return heat
        return heat + self._objective.joint_work * ca.sum1(positive(torques * rates, self._smallest))


def positive(power: ca.SX, smallest: float) -> ca.SX:
    """max(0, power) [W], smooth where power is of the size of `smallest`; 0 at 0."""
    return (power + ca.sqrt(power**2 + smallest**2) - smallest) / 2


def _minimum_jerk(x: float) -> tuple[float, float]:
    """First and second derivative at x of the smoothest way from 0 to 1."""
    left = x * (1 - x)
    return 30 * left * left, 60 * left * (1 - 2 * x)


def _gauss(points: int) -> tuple[Array, Array]:
    """Places and weights of Gauss-Legendre quadrature over both halves of [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    half = (nodes + 1) / 4
    return np.concatenate([half, half + 0.5]), np.concatenate([weights, weights]) / 4


def _standing(limb: Limb, foot: ca.SX) -> tuple[ca.DM, ca.DM]:
    """Matrices [3, 3] from the foot's velocity to the joints' rates, and from its acceleration to their torques."""
    pose = LegPose(limb, foot)
    unit = [ca.SX(ca.DM(np.eye(3)[:, axis])) for axis in range(3)]
    rates, torques = (ca.horzcat(*map(each, unit)) for each in (pose.rates, pose.inertial_torques))
    return ca.DM(rates), ca.DM(torques)
