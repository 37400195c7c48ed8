"""What swinging legs do to the base: the squared sum of the torques of their hips.

Legs have no mass in the dynamics, so a base that recoils from its swings costs nothing there. This term gives it a
cost, which depends on when legs swing and for how long: legs that swing against each other cancel.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from gaitflow.config.robot import Robot
from gaitflow.problem.limb import LegPose
from gaitflow.problem.task import TaskParameters

POINTS = 4  # of a phase: the torques are cubics of time there, so their squares are integrated exactly


class SwingReaction:
    """The squared torque of all swinging legs' hips on the base of a robot with limbs."""

    def __init__(self, robot: Robot) -> None:
        self._feet = [leg.default_foot for leg in robot.legs]
        poses = (
            LegPose(limb, ca.SX(ca.DM(list(foot)))) for limb, foot in zip(robot.limbs or (), self._feet, strict=True)
        )
        self._poses = list(poses)

    def integral(self, task: TaskParameters, durations: ca.SX, contacts: Sequence[ca.SX]) -> ca.SX:
        """Over a cycle of phases that last durations [phases] s, with each leg's contacts [phases] [N^2 m^2 s].

        A leg's one swing goes a cycle's way over the ground, along a minimum-jerk line. Its hip's torques about
        abduction and flexion axis are those of the standing pose; what lifts the foot has little part in them.
        """
        hips = [self._hip(leg, task) for leg in range(len(self._poses))]
        passed = [_passed(durations, 1 - contact) for contact in contacts]
        total = ca.SX(0)
        nodes, weights = np.polynomial.legendre.leggauss(POINTS)
        for phase in range(durations.numel()):
            for s, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
                torque = ca.SX(2, 1)
                for hip, contact, before in zip(hips, contacts, passed, strict=True):
                    swinging = 1 - contact
                    swing = ca.dot(durations, swinging)
                    part = (before[phase] + s * durations[phase]) / swing
                    torque += swinging[phase] * hip * (_minimum_jerk(part) / swing**2)
                total += weight * durations[phase] * ca.sumsqr(torque)
        return total

    def _hip(self, leg: int, task: TaskParameters) -> ca.SX:
        """Torques [2] N m of a leg's hip, abduction and flexion, for a foot's acceleration of a cycle's way a s^2."""
        way = task.passing(self._feet[leg]) * task["cycle_duration"]
        return self._poses[leg].inertial_torques(way)[:2]


def _passed(durations: ca.SX, swinging: ca.SX) -> list[ca.SX]:
    """For how long [s] a leg has been swinging when each phase begins, if it swings in that phase."""
    phases = durations.numel()
    found = []
    for phase in range(phases):
        before, unbroken = ca.SX(0), ca.SX(1)
        for back in range(1, phases):
            unbroken *= swinging[phase - back]
            before += unbroken * durations[phase - back]
        found.append(before)
    return found


def _minimum_jerk(x: ca.SX) -> ca.SX:
    """Second derivative at x of the smoothest way from 0 to 1."""
    return 60 * x * (1 - x) * (1 - 2 * x)
