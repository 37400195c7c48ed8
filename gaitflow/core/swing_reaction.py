"""The squared torque of all swinging legs' hips on the base, computed a second time in numpy; part of the check."""

from __future__ import annotations

import numpy as np

from gaitflow.core.joints import Joints
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array

SAMPLES = 2000  # of a cycle


def swing_reaction(joints: Joints, task: Task, durations: Array, pattern: str) -> float:
    """Its integral over a cycle of phases that last durations [phases] s, of a pattern "0110/1100" [N^2 m^2 s]."""
    times = (np.arange(SAMPLES) + 0.5) / SAMPLES * task.cycle_duration
    starts = np.cumsum(durations) - durations
    command, turned = np.array([task["speed"], task["lateral_speed"], 0.0]), task["yaw_rate"] * np.array([-1, 1, 0])
    along = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6]).deriv(2)
    total = np.zeros((SAMPLES, 2))
    for leg, (limb, row) in enumerate(zip(joints.limbs, pattern.split("/"), strict=True)):
        lifting = next(phase for phase in range(len(row)) if row[phase - 1] == "1" and row[phase] == "0")
        swing = sum(duration for duration, digit in zip(durations, row, strict=True) if digit == "0")
        part = (times - starts[lifting]) % task.cycle_duration / swing
        foot = joints.default_feet[leg]
        way = (command + turned * foot[[1, 0, 2]]) * task.cycle_duration
        torques = limb.inertia @ np.linalg.inv(limb.jacobian(foot)) @ way
        total += np.outer(np.where(part < 1, along(part), 0.0) / swing**2, torques[:2])
    return float((total**2).sum(axis=1).mean() * task.cycle_duration)
