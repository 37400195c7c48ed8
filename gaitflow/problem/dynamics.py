"""Eq. (4): Newton-Euler equations of a single rigid body with massless legs."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from gaitflow.config.robot import Robot
from gaitflow.problem.layout import GRAVITY, Layout
from gaitflow.problem.orientation import angle_rates, moment, world_to_base


def gravity(dimension: int, slope_deg: float) -> list[float]:
    """Gravity [d] m/s^2 in the terrain frame: the slope turns gravity, the ground stays at z = 0."""
    slope = math.radians(slope_deg)
    along, normal = -GRAVITY * math.sin(slope), -GRAVITY * math.cos(slope)
    return [along, normal] if dimension == 2 else [along, 0.0, normal]


def state_rate(robot: Robot, slope_deg: float, layout: Layout, x: ca.SX, u: ca.SX) -> ca.SX:
    """dx/dt [nx] in SI units for the state x [nx] and the control u [nu] (forces in N).

    m r'' = m g + sum f_l; I omega' + omega x (I omega) = sum R (p_l - r) x f_l, in the base frame.
    """
    d, a = layout.dimension, layout.angles
    position, angles = x[:d], x[d : d + a]
    velocity, omega = x[d + a : 2 * d + a], x[2 * d + a : layout.nb]
    force_sum, moment_sum = ca.SX.zeros(d), ca.SX.zeros(a)
    for leg in range(layout.legs):
        foot = x[layout.nb + leg * d : layout.nb + (leg + 1) * d]
        force = u[leg * d : (leg + 1) * d]
        force_sum += force
        moment_sum += moment(foot - position, force)
    acceleration = force_sum / robot.mass + ca.DM(gravity(d, slope_deg))
    inertia = np.array(robot.inertia)
    if d == 3:
        moment_sum = world_to_base(angles) @ moment_sum - ca.cross(omega, ca.DM(inertia) @ omega)
    angular_acceleration = ca.DM(np.linalg.inv(inertia)) @ moment_sum
    foot_velocities = u[layout.legs * d :]
    return ca.vertcat(velocity, angle_rates(angles, omega), acceleration, angular_acceleration, foot_velocities)
