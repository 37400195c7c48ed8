"""The planar twist that a task commands, as numbers: where its frame is at any time of the cycle."""

from __future__ import annotations

import numpy as np

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array


def headings(task: Task, times: Array) -> Array:
    """Directions [n] rad that the frame faces at times [n] s."""
    return task["yaw_rate"] * np.asarray(times)


def displacements(task: Task, times: Array) -> Array:
    """Where the frame's origin is at times [n] s: (x, y) [n, 2] m, by the exponential of the mean twist."""
    times = np.asarray(times)
    turned = headings(task, times)
    along = np.sinc(turned / np.pi)  # sin(a) / a
    across = np.sin(turned / 2) * np.sinc(turned / (2 * np.pi))  # (1 - cos(a)) / a
    v, left = task["speed"], task["lateral_speed"]
    moved: Array = times[..., None] * np.stack([v * along - left * across, v * across + left * along], axis=-1)
    return moved


def velocities(task: Task, times: Array) -> Array:
    """Velocity (x, y) [n, 2] m/s that is commanded at times [n] s, in world directions."""
    times = np.asarray(times)
    forward = task["speed"] + task["acceleration"] * (times - task["cycle_duration"] / 2)
    left, turned = task["lateral_speed"], headings(task, times)
    c, s = np.cos(turned), np.sin(turned)
    return np.stack([forward * c - left * s, forward * s + left * c], axis=-1)
