"""Eq. (8)-(10): the objectives J1, J2, J3 as weighted terms, summed over one step.

Velocity, tilt and lateral feet are taken in the frame that follows the commanded twist. It is aligned with the terrain,
so eq. (9)'s (theta - gamma)^2 is the square of our pitch, v_t the velocity along the ground (in space both of its
components) and v_n the one normal to it.
"""

from __future__ import annotations

import casadi as ca

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Objective
from gaitflow.problem.dynamics import Node
from gaitflow.problem.task import TaskParameters


class StepCost:
    """The cost of one step between two nodes, at times t0 and t1 [s] of the cycle, h = t1 - t0."""

    def __init__(
        self, robot: Robot, task: TaskParameters, ends: tuple[Node, Node], times: tuple[ca.SX, ca.SX], h: ca.SX
    ) -> None:
        self._robot = robot
        self._task = task
        self._start, self._end = ends
        self._t0, self._t1 = times
        self._h = h

    def sampled(self, objective: Objective) -> ca.SX:
        """The integrand at the start times h: the paper's forward Euler."""
        start, at = self._start, self._t0
        velocity, tilt, rate = self._velocity(start, at), self._tilt(start, at), self._tilt_rate(start)
        terms = {
            "force": sum((ca.sumsqr(force) for force in start.forces), ca.SX(0)),
            "tangential_velocity": ca.sumsqr(velocity[:-1]),
            "normal_velocity": velocity[-1] ** 2,
            "tilt": ca.sumsqr(tilt),
            "tilt_rate": ca.sumsqr(rate),
            "lateral_foot": sum((y**2 for y in self._lateral_feet(start, at)), ca.SX(0)),
        }
        return self._h * _weighted(objective, terms)

    def integrated(self, objective: Objective) -> ca.SX:
        """The integral of each square along the interpolated motion.

        Forces and feet are linear in time, velocities quadratic: for these it is exact. Tilt and tilt rate count as the
        quadratics through their ends with the right mean. Sums of squares all, so no motion has a negative cost.
        """
        start, end, h = self._start, self._end, self._h
        middle = (self._t0 + self._t1) / 2
        velocity = self._velocity(start, self._t0), self._velocity(end, self._t1)
        wanted = (
            self._task.velocity(self._t0, _dimension(start)) + self._task.velocity(self._t1, _dimension(start))
        ) / 2
        travel = self._task.into_frame(end.position - start.position, middle) - h * wanted
        along = _squares_of_mean(velocity[0], velocity[1], travel, h)
        tilt = self._tilt(start, self._t0), self._tilt(end, self._t1)
        rate = self._tilt_rate(start), self._tilt_rate(end)
        half_way = (tilt[0] + tilt[1]) / 2 + h / 8 * (rate[0] - rate[1])
        feet = zip(self._lateral_feet(start, self._t0), self._lateral_feet(end, self._t1), strict=True)
        forces = zip(start.forces, end.forces, strict=True)
        terms = {
            "force": sum((_squares_of_line(first, last, h) for first, last in forces), ca.SX(0)),
            "tangential_velocity": ca.sum1(along[:-1]),
            "normal_velocity": along[-1],
            "tilt": ca.sum1(_squares(tilt[0], half_way, tilt[1], h)),
            "tilt_rate": ca.sum1(_squares_of_mean(rate[0], rate[1], tilt[1] - tilt[0], h)),
            "lateral_foot": sum((_squares_of_line(first, last, h) for first, last in feet), ca.SX(0)),
        }
        return _weighted(objective, terms)

    def _velocity(self, end: Node, time: ca.SX) -> ca.SX:
        return self._task.into_frame(end.velocity, time) - self._task.velocity(time, _dimension(end))

    def _tilt(self, end: Node, time: ca.SX) -> ca.SX:
        angles = ca.SX(end.angles)
        angles[0] -= self._task.heading(time) if angles.numel() == 3 else 0
        return angles

    def _tilt_rate(self, end: Node) -> ca.SX:
        rates = ca.SX(end.angle_rates)
        rates[0] -= self._task["yaw_rate"] if rates.numel() == 3 else 0
        return rates

    def _lateral_feet(self, end: Node, time: ca.SX) -> list[ca.SX]:
        """How far each foot is to the left of its default place beside the commanded path."""
        if self._robot.dimension == 2:
            return []
        origin = ca.vertcat(*self._task.displacement(time), 0)
        return [
            self._task.into_frame(foot - origin, time)[1] - leg.default_foot[1]
            for leg, foot in zip(self._robot.legs, end.feet, strict=True)
        ]


def _dimension(end: Node) -> int:
    """Number of coordinates d."""
    return int(end.position.numel())


def _weighted(objective: Objective, terms: dict[str, ca.SX]) -> ca.SX:
    weights = objective.as_data()
    return sum((weights[name] * term for name, term in terms.items() if weights[name]), ca.SX(0))


def _squares(first: ca.SX, middle: ca.SX, last: ca.SX, h: ca.SX) -> ca.SX:
    """Integral of the square of the quadratic through three values, elementwise."""
    ends = 4 * first**2 + 4 * last**2 - 2 * first * last
    return h / 30 * (ends + 16 * middle**2 + 4 * middle * (first + last))


def _squares_of_mean(first: ca.SX, last: ca.SX, integral: ca.SX, h: ca.SX) -> ca.SX:
    """The same of the quadratic with these ends and this integral."""
    return _squares(first, (6 * integral / h - first - last) / 4, last, h)


def _squares_of_line(first: ca.SX, last: ca.SX, h: ca.SX) -> ca.SX:
    """The same of the line through both ends, summed."""
    return h / 3 * (ca.sumsqr(first) + ca.dot(first, last) + ca.sumsqr(last))
