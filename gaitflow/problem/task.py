"""The task of a problem as expressions, and the planar twist that it commands.

The command (speed, lateral_speed, yaw_rate) moves a frame along the ground, F(t) = exp(t xi). After a cycle base and
feet are the first ones moved by F(T) (section III.B.1, for more than forward speed).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from gaitflow.config.scenario import Tasks
from gaitflow.core.task import AXES

SMALL_ANGLE = 1e-4  # rad; below it the quotients of exp are those at this angle, which are right to 1e-8


@dataclass(frozen=True)
class TaskParameters:
    """An expression for every axis; an axis that a scenario fixes at 0 is the constant 0, so its terms vanish."""

    values: dict[str, ca.SX]

    def __getitem__(self, axis: str) -> ca.SX:
        return self.values[axis]

    @property
    def slope(self) -> ca.SX:
        """gamma [rad]."""
        return self["slope"] * (ca.pi / 180)

    def heading(self, time: ca.SX) -> ca.SX:
        """Direction [rad] that the commanded frame faces at a time [s]."""
        return self["yaw_rate"] * time

    def velocity(self, time: ca.SX, dimension: int) -> ca.SX:
        """Commanded velocity [d] m/s in the frame's own directions: forward, left, up."""
        forward = self["speed"] + self["acceleration"] * (time - self["cycle_duration"] / 2)
        return ca.vertcat(forward, 0) if dimension == 2 else ca.vertcat(forward, self["lateral_speed"], 0)

    def passing(self, place: Sequence[float]) -> ca.SX:
        """Mean commanded velocity [3] m/s of a place (x, y) of the frame, in its directions; in space."""
        x, y = place[0], place[1]
        return self.velocity(self["cycle_duration"] / 2, 3) + self["yaw_rate"] * ca.DM([-y, x, 0.0])

    def displacement(self, time: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Where the frame's origin is at a time [s], (x, y) m, by the exponential of the mean twist."""
        turned = self.heading(time)
        small = ca.fabs(turned) < SMALL_ANGLE
        angle = ca.if_else(small, SMALL_ANGLE, turned)
        along, across = ca.sin(angle) / angle, ca.if_else(small, turned / 2, (1 - ca.cos(angle)) / angle)
        if turned.is_zero():
            along, across = ca.SX(1), ca.SX(0)
        v, left = self["speed"], self["lateral_speed"]
        return time * (v * along - left * across), time * (v * across + left * along)

    def into_frame(self, vector: ca.SX, time: ca.SX) -> ca.SX:
        """A world vector [d] in the directions of the frame at a time [s]."""
        return self._turned(vector, -self.heading(time))

    def out_of_frame(self, vector: ca.SX, time: ca.SX) -> ca.SX:
        """A vector [d] in the directions of the frame at a time [s] in those of the world."""
        return self._turned(vector, self.heading(time))

    @staticmethod
    def _turned(vector: ca.SX, angle: ca.SX) -> ca.SX:
        if vector.numel() == 2 or angle.is_zero():
            return vector
        c, s = ca.cos(angle), ca.sin(angle)
        return ca.vertcat(c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2])


def task_parameters(tasks: Tasks, parameters: ca.SX) -> TaskParameters:
    """The axes of a scenario's tasks as expressions of the problem's parameters [axes], in the order of AXES."""
    return TaskParameters({axis: parameters[i] if tasks.varies(axis) else ca.SX(0) for i, axis in enumerate(AXES)})
