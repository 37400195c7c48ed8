"""A trot of round numbers: 0.5 m/s, 0.8 s, each diagonal pair for half of the cycle, level at 0.5 m."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from bodies import SPATIAL
from cyclic import STEPS, cyclic, cyclic_scenario

from gaitflow.core.layout import GRAVITY, Layout
from gaitflow.core.task import Task
from gaitflow.motion import Motion

PATTERN = "0011/1100/1100/0011"  # LF, RF, LH, RH


def trot() -> Motion:
    """Footholds are below the default foot in the middle of their stance."""
    data, task = cyclic_scenario(SPATIAL), Task.of({"speed": 0.5, "cycle_duration": 0.8})
    durations = np.full(4, 0.2)
    made, times = cyclic(data, task, PATTERN, 0), Layout.of(data).times(durations)
    default = np.array([leg["default_foot"] for leg in data["robot"]["legs"]])
    base, feet = np.zeros_like(made.base), np.zeros_like(made.feet)
    base[:, 0], base[:, 2], base[:, 6] = 0.5 * times, 0.5, 0.5
    feet[..., :2] = default[:, :2] + np.array([0.5 * 0.2, 0.0])
    feet[2 * STEPS :, [0, 3], 0] += 0.2
    feet[-1, [1, 2], 0] += 0.4
    feet[0, [0, 3]] = feet[-1, [0, 3]] - [0.4, 0.0, 0.0]
    forces = np.zeros_like(made.forces)
    forces[: 2 * STEPS, [1, 2], 2] = forces[2 * STEPS :, [0, 3], 2] = data["robot"]["mass"] * GRAVITY / 2
    motion = replace(made, times=times, durations=durations, base=base, feet=feet, forces=forces, end_forces=forces)
    return Motion.of(data, motion, task, PATTERN)
