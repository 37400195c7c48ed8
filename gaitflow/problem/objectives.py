"""Eq. (8)-(10): the integrands of the performance objectives, weighted and summed."""

from __future__ import annotations

import casadi as ca

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Objective
from gaitflow.problem.layout import Layout
from gaitflow.problem.orientation import angle_rates


def integrand(objective: Objective, robot: Robot, layout: Layout, x: ca.SX, u: ca.SX, speed: ca.SX) -> ca.SX:
    """The running cost [1] at a state x [nx] and a control u [nu] (forces in N), all in SI units.

    The frame is aligned with the terrain, so eq. (9)'s (theta - gamma)^2 is the square of our pitch, v_t the velocity
    along the ground (in space both of its components) and v_n the one normal to it.
    """
    d, a = layout.dimension, layout.angles
    angles, velocity = x[d : d + a], x[d + a : 2 * d + a]
    rates = angle_rates(angles, x[2 * d + a : layout.nb])
    terms = [
        (objective.force, lambda: ca.sumsqr(u[: layout.legs * d])),
        (objective.tangential_velocity, lambda: (velocity[0] - speed) ** 2 + ca.sumsqr(velocity[1 : d - 1])),
        (objective.normal_velocity, lambda: velocity[d - 1] ** 2),
        (objective.tilt, lambda: ca.sumsqr(angles)),
        (objective.tilt_rate, lambda: ca.sumsqr(rates)),
        (objective.lateral_foot, lambda: _lateral_feet(robot, layout, x)),
    ]
    return sum((weight * term() for weight, term in terms if weight), ca.SX(0))


def _lateral_feet(robot: Robot, layout: Layout, x: ca.SX) -> ca.SX:
    squares = [
        (x[layout.nb + index * layout.dimension + 1] - leg.default_foot[1]) ** 2 for index, leg in enumerate(robot.legs)
    ]
    return ca.sum1(ca.vertcat(*squares))
