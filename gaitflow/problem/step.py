"""One step of the integrators that a scenario may name: rows that ask for 0 between the nodes at its two ends.

euler, of the paper (section III.B), and rk4 are explicit; the others treat both ends alike, so a motion run backwards
is a motion, too. `momentum` is made for this body: with forces linear in time, linear momentum, position and the
angular momentum about a fixed point are exact polynomials of what is at the two ends, however long the step. So is the
pitch in the plane; in space the angles are integrated to fourth order (Hermite-Obreshkov), from their first and second
derivatives.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from gaitflow.problem.dynamics import Node, node
from gaitflow.problem.orientation import moment

Rule = Callable[[Node, Node, ca.SX], ca.SX]


def base_defects(integrator: str, start: Node, end: Node, h: ca.SX) -> ca.SX:
    """What the base state at the end differs from the step's [nb], for a step of h [s]; 0 on a motion."""
    return RULES[integrator](start, end, h)


def euler(start: Node, end: Node, h: ca.SX) -> ca.SX:
    """x_1 - x_0 - h f(x_0, u_0)."""
    return end.base - start.base - h * start.rate


def rk4(start: Node, end: Node, h: ca.SX) -> ca.SX:
    """The classical Runge-Kutta step, feet and forces running linearly."""
    k1 = start.rate
    k2 = _between(start, end, start.base + h / 2 * k1).rate
    k3 = _between(start, end, start.base + h / 2 * k2).rate
    k4 = node(end.body, start.base + h * k3, end.feet, end.forces).rate
    return end.base - start.base - h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def midpoint(start: Node, end: Node, h: ca.SX) -> ca.SX:
    """x_1 - x_0 - h f at the mean of both ends, of second order."""
    return end.base - start.base - h * _between(start, end, (start.base + end.base) / 2).rate


def hermite_simpson(start: Node, end: Node, h: ca.SX) -> ca.SX:
    """Simpson's rule with the middle of the cubic through both ends, of fourth order."""
    middle = _between(start, end, (start.base + end.base) / 2 + h / 8 * (start.rate - end.rate))
    return end.base - start.base - h / 6 * (start.rate + 4 * middle.rate + end.rate)


def momentum(start: Node, end: Node, h: ca.SX) -> ca.SX:
    """Exact linear and angular momentum, position, and pitch in the plane; angles in space to fourth order.

    A foot that carries a force stands still, so its moment about the origin has the mean p x (f_0 + f_1) / 2; gravity
    acts at the body, whose path is a cubic.
    """
    body = start.body
    path = h / 2 * (start.position + end.position) + h**2 / 12 * (start.velocity - end.velocity)
    gained = body.mass * moment(path, body.gravity)
    for foot, first, last in zip(start.feet, start.forces, end.forces, strict=True):
        gained += h / 2 * moment(foot, first + last)
    turned = _obreshkov(
        start.angles, end.angles, start.angle_rates, end.angle_rates,
        start.angle_accelerations, end.angle_accelerations, h,
    )  # fmt: skip
    if turned.numel() == 1:
        turned -= _quartic_turn(start, end, h)
    return ca.vertcat(
        _obreshkov(start.position, end.position, start.velocity, end.velocity, start.acceleration, end.acceleration, h),
        turned,
        end.velocity - start.velocity - h / 2 * (start.acceleration + end.acceleration),
        (end.angular_momentum - start.angular_momentum - gained) / body.mean_inertia,
    )


def _quartic_turn(start: Node, end: Node, h: ca.SX) -> ca.SX:
    """What `_obreshkov` lacks of a pitch in the plane [1]: h^5 / 720 times the fourth derivative of its rate.

    The angular momentum about the centre of mass has the fourth derivative -(2 r'' + g) x F', with F the sum of forces;
    it is constant in a step, as r'' and F run linearly.
    """
    mean_acceleration = (end.velocity - start.velocity) / h
    change = sum(end.forces[1:], end.forces[0]) - sum(start.forces[1:], start.forces[0])
    return -(h**4) / 720 * moment(2 * mean_acceleration + start.body.gravity, change) / start.body.inertia


def _obreshkov(q0: ca.SX, q1: ca.SX, rate0: ca.SX, rate1: ca.SX, second0: ca.SX, second1: ca.SX, h: ca.SX) -> ca.SX:
    """q_1 - q_0 minus the integral of a rate known with its derivative at both ends; exact for a cubic rate."""
    return q1 - q0 - h / 2 * (rate0 + rate1) - h**2 / 12 * (second0 - second1)


def _between(start: Node, end: Node, base: ca.SX) -> Node:
    """The node in the middle of a step with a given base."""
    feet = [(a + b) / 2 for a, b in zip(start.feet, end.feet, strict=True)]
    forces = [(a + b) / 2 for a, b in zip(start.forces, end.forces, strict=True)]
    return node(start.body, base, feet, forces)


RULES: dict[str, Rule] = {
    "euler": euler,
    "rk4": rk4,
    "midpoint": midpoint,
    "hermite_simpson": hermite_simpson,
    "momentum": momentum,
}
