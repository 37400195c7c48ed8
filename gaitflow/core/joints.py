"""J4 computed a second time, in numpy: torques and rates of joints, for the check's own cost.

Written without the transcription's code: the joints' angles are solved for, and torques and rates come from the
Jacobian of axes and levers. Arrays have any leading axes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gaitflow.core.rigid_body import G
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array

SMOOTH_POWER = 0.1  # W/kg, of the objective
SWING_SAMPLES = 400


@dataclass(frozen=True, eq=False)
class Limb:
    """A leg of a robot's JSON data: hip [3] m, lengths m, inertia [3, 3] kg m^2 of its joints in the standing pose."""

    hip: Array
    aside: float
    below: float
    thigh: float
    shank: float
    bend: float  # 1: the knee is before the line from hip to foot
    mass: float  # kg
    inertia: Array

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> Limb:
        """A limb of a robot's JSON data."""
        inertia = np.zeros((3, 3))
        inertia[0, 0], inertia[1:, 1:] = data["abduction_inertia"], data["flexion_inertia"]
        return cls(
            hip=np.array(data["hip"], dtype=float),
            aside=float(data["aside"]),
            below=float(data["below"]),
            thigh=float(data["thigh"]),
            shank=float(data["shank"]),
            bend=1.0 if data["knee"] == "forward" else -1.0,
            mass=float(data["mass"]),
            inertia=inertia,
        )

    def length(self, foot: Array) -> Array:
        """From hip to foot, over thigh and shank together, of a foot at places [..., 3] m of the base frame."""
        x, y, z = np.moveaxis(foot - self.hip, -1, 0)
        down = np.sqrt(np.maximum(y**2 + z**2 - self.aside**2, 0.0)) - self.below
        return np.asarray(np.hypot(x, down) / (self.thigh + self.shank))

    def jacobian(self, foot: Array) -> Array:
        """Of a foot at places [..., 3] m of the base frame, by the joints' angles [..., 3, 3]."""
        x, y, z = np.moveaxis(foot - self.hip, -1, 0)
        down = np.sqrt(y**2 + z**2 - self.aside**2)
        abduction = np.arctan2(y, -z) - np.arctan2(self.aside, down)  # of the plane, from hanging straight down
        down = down - self.below
        length = np.hypot(x, down)
        at_hip = np.arccos((length**2 + self.thigh**2 - self.shank**2) / (2 * length * self.thigh))
        swung = np.arctan2(x, down) + self.bend * at_hip  # of the thigh, forward
        axis = _stack(np.zeros_like(x), np.cos(abduction), np.sin(abduction))
        under = _stack(np.zeros_like(x), np.sin(abduction), -np.cos(abduction))
        flexion = self.below * under + self.aside * axis
        thigh = self.thigh * (np.sin(swung)[..., None] * [1.0, 0.0, 0.0] + np.cos(swung)[..., None] * under)
        from_hip = foot - self.hip
        forward = np.broadcast_to([1.0, 0.0, 0.0], foot.shape)
        columns = [
            np.cross(forward, from_hip),
            np.cross(axis, from_hip - flexion),
            np.cross(axis, from_hip - flexion - thigh),
        ]
        return np.stack(columns, axis=-1)


@dataclass(frozen=True, eq=False)
class Joints:
    """All limbs of a robot, and the weights of heat and work."""

    limbs: Sequence[Limb]
    default_feet: Array
    heat: float
    work: float
    smallest: float  # W

    @classmethod
    def of(cls, scenario: Mapping[str, Any]) -> Joints | None:
        """The joints that a scenario's objective counts; None where it does not."""
        objective, robot = scenario["objective"], scenario["robot"]
        heat, work = float(objective.get("joint_heat", 0.0)), float(objective.get("joint_work", 0.0))
        if not heat and not work:
            return None
        feet = np.array([leg["default_foot"] for leg in robot["legs"]], dtype=float)
        limbs = [Limb.of(limb) for limb in robot["limbs"]]
        return cls(limbs, feet, heat, work, SMOOTH_POWER * float(robot["mass"]))

    def standing(self, feet: Array, velocities: Array, forces: Array) -> Array:
        """Weighted watts [...] of legs that push; all [..., legs, 3] in the base frame: places and velocities against
        the base, forces on the robot."""
        total = np.zeros(feet.shape[:-2])
        for leg, limb in enumerate(self.limbs):
            jacobian = limb.jacobian(feet[..., leg, :])
            torques = -np.einsum("...ij,...i->...j", jacobian, forces[..., leg, :])
            rates = np.asarray(np.linalg.solve(jacobian, velocities[..., leg, :, None])[..., 0], dtype=np.float64)
            total += self._watts(torques, rates)
        return total

    def swings(self, task: Task, durations: Array, apex: float) -> float:
        """Weighted joules of a swing of each leg, of durations [legs] s, along the curve that is followed."""
        x = (np.arange(SWING_SAMPLES) + 0.5) / SWING_SAMPLES
        command, turned = np.array([task["speed"], task["lateral_speed"], 0.0]), task["yaw_rate"] * np.array([-1, 1, 0])
        along = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
        up, rises = 2 * x % 1, np.where(x < 0.5, 1.0, -1.0) * [[0.0], [0.0], [apex]]
        total = 0.0
        for leg, (limb, duration) in enumerate(zip(self.limbs, durations, strict=True)):
            body = command + turned * self.default_feet[leg, [1, 0, 2]]
            way = body[:, None] * task.cycle_duration
            velocity = (way * along.deriv()(x) + 2 * rises * along.deriv()(up)) / duration - body[:, None]
            acceleration = (way * along.deriv(2)(x) + 4 * rises * along.deriv(2)(up)) / duration**2
            inverse = np.linalg.inv(limb.jacobian(self.default_feet[leg]))
            watts = self._watts((limb.inertia @ inverse @ acceleration).T, (inverse @ velocity).T)
            total += float(watts.mean()) * duration + self.work * limb.mass * G * apex / 2
        return total

    def _watts(self, torques: Array, rates: Array) -> Array:
        power = torques * rates
        positive = (power + np.hypot(power, self.smallest) - self.smallest) / 2
        return np.asarray(self.heat * (torques**2).sum(axis=-1) + self.work * positive.sum(axis=-1))


def _stack(*components: Array) -> Array:
    return np.stack(components, axis=-1)
