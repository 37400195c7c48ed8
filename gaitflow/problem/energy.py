"""J4: the energy of the joints, as their torques squared (heat) and their positive work.

Legs stay massless in the dynamics. *Standing* legs carry the forces, in the pose that the foot's position determines.
*Swinging* legs carry their own mass along the curve that a robot follows. The program's own feet in the air do not
count, because no other term of the cost depends on them. Swings are computed in the standing pose, so a swing's cost
depends only on its duration, and a short swing is dear.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from gaitflow.config.limbs import Limb
from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Objective
from gaitflow.core.layout import GRAVITY
from gaitflow.core.trajectory import Array
from gaitflow.problem.limb import LegPose
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

    def standing(self, leg: int, place: ca.SX, velocity: ca.SX, force: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Torques [3] N m and rates [3] rad/s of a leg that carries a force [3] N; all in the base frame.

        place, velocity [3]: its foot's.
        """
        pose = LegPose(self._limbs[leg], place)
        return -pose.torques(force), pose.rates(velocity)

    def swing(self, leg: int, task: TaskParameters, duration: ca.SX, apex: float) -> ca.SX:
        """Of a leg's one swing of a duration [s]: the curve that is followed, see `gaitflow.motion.swing`.

        Over the ground a minimum-jerk line as long as a cycle's way, in height such a piece up to `apex` [m] and one
        down, against the leg's place in a body that moves as commanded; and the leg's mass lifted by half the apex.
        """
        to_rates, to_torques = self._standing[leg]
        passing, up = task.passing(self._feet[leg]), ca.DM([0.0, 0.0, apex])
        way = passing * task["cycle_duration"]
        slide, way_rates, up_rates = to_rates @ passing, to_rates @ way, to_rates @ up
        way_torques, up_torques = to_torques @ way, to_torques @ up
        squares, work = ca.SX(0), ca.SX(0)
        for part, weight in zip(*_gauss(SWING_POINTS), strict=True):
            (pace, gain), (climb, push) = _minimum_jerk(part), _minimum_jerk(2 * part % 1)
            sign = 1 if part < 0.5 else -1
            torques = gain * way_torques + 4 * sign * push * up_torques  # times the duration squared
            rates = pace * way_rates + 2 * sign * climb * up_rates - slide * duration  # times the duration
            squares += weight * ca.sumsqr(torques)
            work += weight * ca.sum1(positive(torques * rates / duration**3, self._smallest))
        lifted = self._limbs[leg].mass * GRAVITY * apex / 2
        heat = self._objective.joint_heat * squares / duration**3
        return heat + self._objective.joint_work * (lifted + work * duration)

    def per_second(self, torques: ca.SX, rates: ca.SX) -> ca.SX:
        """Weighted heat and work of joints by their torques [n] N m and rates [n] rad/s, per second."""
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
