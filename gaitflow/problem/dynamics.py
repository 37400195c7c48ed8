"""Eq. (4): Newton-Euler equations of a single rigid body with massless legs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from gaitflow.config.robot import Robot
from gaitflow.core.layout import GRAVITY
from gaitflow.problem.orientation import angle_rates, moment, world_to_base
from gaitflow.problem.task import TaskParameters


@dataclass(frozen=True)
class Body:
    """mass [kg], inertia [a, a] kg m^2 in the base frame, gravity [d] m/s^2 in the terrain frame."""

    mass: ca.SX
    inertia: ca.DM
    gravity: ca.SX

    @property
    def mean_inertia(self) -> float:
        """Mean of the inertia's diagonal [kg m^2], by which rows of angular momentum are scaled."""
        return float(np.diagonal(self.inertia.full()).mean())


def body_of(robot: Robot, task: TaskParameters) -> Body:
    """The robot's body with a task's payload on its ground: the slope turns gravity, the ground stays at z = 0."""
    along, normal = -GRAVITY * ca.sin(task.slope), -GRAVITY * ca.cos(task.slope)
    gravity = ca.vertcat(along, normal) if robot.dimension == 2 else ca.vertcat(along, 0, normal)
    return Body(robot.mass + task["payload"], ca.DM(np.array(robot.inertia)), gravity)


@dataclass(frozen=True, eq=False)
class Node:
    """One end of a step: the base, the feet, and the forces on them, all in SI units; and what follows from them.

    position, velocity [d]; angles, omega [a], omega in the base frame; feet, forces: [d] each, one a leg.
    """

    body: Body
    position: ca.SX
    angles: ca.SX
    velocity: ca.SX
    omega: ca.SX
    feet: tuple[ca.SX, ...]
    forces: tuple[ca.SX, ...]

    @cached_property
    def base(self) -> ca.SX:
        """The base state [nb]."""
        return ca.vertcat(self.position, self.angles, self.velocity, self.omega)

    @cached_property
    def acceleration(self) -> ca.SX:
        """r'' [d] m/s^2: m r'' = m g + sum f_l."""
        return sum(self.forces[1:], self.forces[0]) / self.body.mass + self.body.gravity

    @cached_property
    def angular_acceleration(self) -> ca.SX:
        """omega' [a] rad/s^2: I omega' + omega x (I omega) = sum R (p_l - r) x f_l, in the base frame."""
        inertia = self.body.inertia
        total = ca.SX.zeros(self.angles.numel())
        for foot, force in zip(self.feet, self.forces, strict=True):
            total += moment(foot - self.position, force)
        if self.omega.numel() == 3:
            total = world_to_base(self.angles) @ total - ca.cross(self.omega, inertia @ self.omega)
        return ca.inv(inertia) @ total

    @cached_property
    def angle_rates(self) -> ca.SX:
        """d/dt of the angles [a] rad/s."""
        return angle_rates(self.angles, self.omega)

    @cached_property
    def angle_accelerations(self) -> ca.SX:
        """d^2/dt^2 of the angles [a] rad/s^2, by the chain rule."""
        if self.omega.numel() == 1:
            return self.angular_acceleration
        angles, omega = ca.SX.sym("angles", 3), ca.SX.sym("omega", 3)
        rates, spin = ca.SX.sym("rates", 3), ca.SX.sym("spin", 3)
        of_rates = angle_rates(angles, omega)
        change = ca.jtimes(of_rates, angles, rates) + ca.jtimes(of_rates, omega, spin)
        chain = ca.Function("chain", [angles, omega, rates, spin], [change])
        return chain(self.angles, self.omega, self.angle_rates, self.angular_acceleration)

    @cached_property
    def rate(self) -> ca.SX:
        """d/dt of the base state [nb]."""
        return ca.vertcat(self.velocity, self.angle_rates, self.acceleration, self.angular_acceleration)

    @cached_property
    def angular_momentum(self) -> ca.SX:
        """Angular momentum [a] kg m^2/s about the world's origin, in world directions."""
        spin = self.body.inertia @ self.omega
        if self.omega.numel() == 3:
            spin = world_to_base(self.angles).T @ spin
        return spin + self.body.mass * moment(self.position, self.velocity)


def node(body: Body, base: ca.SX, feet: Sequence[ca.SX], forces: Sequence[ca.SX]) -> Node:
    """The node with a base state [nb], and a foot's place and force [d] for each leg."""
    d = feet[0].numel()
    a = base.numel() // 2 - d
    position, angles, velocity, omega = ca.vertsplit(base, [0, d, d + a, 2 * d + a, 2 * (d + a)])
    return Node(body, position, angles, velocity, omega, tuple(feet), tuple(forces))
