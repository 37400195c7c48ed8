"""Are legs long enough for the swings that are followed? Part of the check, in numpy.

A leg is at its longest soon after its foot left the ground, when the body has run ahead of it, and soon before it
touches down. At these times the foot's curve is compared with a body that keeps its velocity and attitude.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gaitflow.core.joints import Limb
from gaitflow.core.rigid_body import Attitude, RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory

LONGEST = 0.96  # of thigh and shank
PARTS = np.array([0.1, 0.15, 0.2])  # of a swing


def reach_excess(
    scenario: Mapping[str, Any], body: RigidBody, trajectory: Trajectory, task: Task, pattern: str
) -> float:
    """How much longer than LONGEST allows a leg gets in a swing of a pattern "0110/1100", over that; 0 where none."""
    robot, apex, rows = scenario["robot"], float(scenario["swing_clearance"]), pattern.split("/")
    n = len(trajectory.foot_velocities) // len(rows[0])
    along = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
    worst = 0.0
    for leg, row in enumerate(rows):
        limb, phases = Limb.of(robot["limbs"][leg]), len(row)
        swing = float(sum(trajectory.durations[phase] for phase in range(phases) if row[phase] == "0"))
        for phase in range(phases):
            change = int(row[phase]) - int(row[(phase + 1) % phases])
            if not change:
                continue
            knot = (phase + 1) * n
            position, angles, velocity, _ = body.split(trajectory.base[knot])
            way = _way(task, body.default_feet[leg], float(trajectory.times[knot]))
            places = trajectory.feet[knot, leg] - position + change * np.outer(along(PARTS), way)
            places = places - change * swing * np.outer(PARTS, velocity)
            places[:, 2] += apex * along(2 * PARTS)
            seen = Attitude(np.broadcast_to(angles, places.shape)).into_base(places)
            worst = max(worst, float(limb.length(seen).max()) / LONGEST - 1)
    return worst


def _way(task: Task, foot: Array, time: float) -> Array:
    """How far [3] m a foot goes in a cycle, by the command at a time [s]."""
    turn = task["yaw_rate"]
    ground = complex(task["speed"], task["lateral_speed"]) + 1j * turn * complex(foot[0], foot[1])
    moved = ground * np.exp(1j * turn * time) * task.cycle_duration
    return np.array([moved.real, moved.imag, 0.0])
