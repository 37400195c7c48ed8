"""How fast the contact forces of a stored motion change; part of the check."""

from __future__ import annotations

import numpy as np

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory

EDGE = 0.02  # s: about as long as a motor takes to build up a torque


def force_rate(trajectory: Trajectory, h: Array, task: Task) -> float:
    """Integral of the squared rates of all contact forces over a cycle [N^2/s]; h [K] s are the steps' durations.

    A jump from one step to the next, or from the last one to the first of the next cycle, counts as a ramp of EDGE
    seconds; forces of that cycle are turned by the task's yaw.
    """
    changed = trajectory.end_forces - trajectory.forces
    after = np.roll(trajectory.forces, -1, axis=0)
    if after.shape[-1] == 3:
        yaw = task["yaw_rate"] * task.cycle_duration
        cos, sin = np.cos(yaw), np.sin(yaw)
        after[-1] = after[-1] @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    jumps = after - trajectory.end_forces
    return float((changed**2).sum(axis=(1, 2)) @ (1 / h) + (jumps**2).sum() / EDGE)
