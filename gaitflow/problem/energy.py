"""J4: what moving takes of the joints, their torques squared (heat) and their positive work.

Legs stay massless in the dynamics. *Standing* legs carry the forces, in the pose that the foot's place asks for.
*Swinging* legs carry their own mass: a foot's acceleration asks for torques, so a short swing is a dear one. Theirs are
the torques and rates of the standing pose, which keeps swings a matter of the foot's velocities alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from gaitflow.config.limbs import Limb
from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Objective
from gaitflow.problem.dynamics import Node
from gaitflow.problem.limb import LegPose
from gaitflow.problem.orientation import world_to_base

Pushed = tuple[ca.SX, ca.SX]

SMOOTH_POWER = 0.2  # W/kg: a fiftieth of what lifting the robot at 1 m/s takes
# What follows a plan swings feet along minimum-jerk curves. They peak at 1.875 times their mean speed; the swing of
# least acceleration, to which this cost draws the plan's own, at 1.5 times.
SHARPER = 1.25


class JointCost:
    """Weighted heat and work of a robot's joints, by their torques and rates; see `Objective`."""

    def __init__(self, robot: Robot, objective: Objective) -> None:
        self._limbs = robot.limbs or ()
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

    def swinging(self, leg: int, start: Pushed, end: Pushed) -> ca.SX:
        """Of a leg that swings, the mean over a step per second.

        start, end: the foot's velocity [3] m/s against the body and its acceleration [3] m/s^2 there, in the command's
        frame; lines between. By Simpson's rule, which for heat is exact.
        """
        rates, torques = self._standing[leg]
        middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
        pushed = [(velocity, SHARPER * torques @ push) for velocity, push in (start, middle, end)]
        watts = [self._per_second(torque, rates @ velocity) for velocity, torque in pushed]
        return (watts[0] + 4 * watts[1] + watts[2]) / 6

    def _per_second(self, torques: ca.SX, rates: ca.SX) -> ca.SX:
        heat = self._objective.joint_heat * ca.sumsqr(torques)
        if not self._objective.joint_work:
            return heat
        return heat + self._objective.joint_work * ca.sum1(positive(torques * rates, self._smallest))


def positive(power: ca.SX, smallest: float) -> ca.SX:
    """max(0, power) [W], smooth where power is of the size of `smallest`; 0 at 0."""
    return (power + ca.sqrt(power**2 + smallest**2) - smallest) / 2


def knot_motion(velocities: Sequence[ca.SX], steps: Sequence[ca.SX]) -> list[Pushed]:
    """Velocity [d] m/s and acceleration [d] m/s^2 of a foot at K + 1 knots, in a frame in which it is periodic.

    They are those of the line from the middle of one step to that of the next. velocities [d] m/s and steps s are of
    the K steps.
    """
    found = []
    for k, (now, step) in enumerate(zip(velocities, steps, strict=True)):
        then, last = velocities[k - 1], steps[k - 1]
        found.append(((then * step + now * last) / (last + step), 2 * (now - then) / (last + step)))
    return [*found, found[0]]


def _standing(limb: Limb, foot: ca.SX) -> tuple[ca.DM, ca.DM]:
    """Matrices [3, 3] from the foot's velocity to the joints' rates, and from its acceleration to their torques."""
    pose = LegPose(limb, foot)
    unit = [ca.SX(ca.DM(np.eye(3)[:, axis])) for axis in range(3)]
    return tuple(ca.DM(ca.horzcat(*(each(axis) for axis in unit))) for each in (pose.rates, pose.inertial_torques))
