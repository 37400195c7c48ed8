"""Cycles that close exactly, made without a solver: forces at will that keep a body on its commanded path."""

from __future__ import annotations

from typing import Any

import numpy as np

from gaitflow.core.layout import Layout
from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.core.twist import displacements

PHASES, STEPS = 4, 3


def cyclic_scenario(robot: dict[str, Any]) -> dict[str, Any]:
    """JSON of a scenario whose tasks may have any axis; its legs get names."""
    legs = [{"name": name} | leg for name, leg in zip(("LF", "RF", "LH", "RH"), robot["legs"], strict=False)]
    return {
        "name": "made-by-hand",
        "robot": robot | {"legs": legs, "max_force": 500.0, "max_foot_speed": 8.0, "max_tilt": 1.0},
        "objective": {"force": 1.0},
        "transcription": {
            "phases": PHASES,
            "knots_per_phase": STEPS,
            "integrator": "momentum",
            "forces": "linear",
            "grading": 0.7,
            "min_phase_fraction": 0.1,
        },
        "tasks": {"axes": {"speed": {"start": 0.0, "stop": 1.0, "count": 2}, "cycle_duration": 0.6}},
    }


def cyclic(data: dict[str, Any], task: Task, pattern: str, seed: int) -> Trajectory:
    """A random cycle of a task with these contacts, in which some leg stands; exact but for the orientation.

    Forces are linear in each step and jump; those of legs in swing are 0. Feet move in straight lines between knots.
    """
    layout, body, rng = Layout.of(data), RigidBody.of(data["robot"], task), np.random.default_rng(seed)
    d, period = layout.dimension, task.cycle_duration
    durations = period * rng.dirichlet(np.full(PHASES, 8.0))
    durations[-1] = period - durations[:-1].sum()
    times = layout.times(durations)
    times[-1] = period
    h = np.diff(times)
    stance = np.repeat(np.array([[digit == "1" for digit in row] for row in pattern.split("/")]).T, STEPS, axis=0)
    turn, shift = _step(task, d)
    gain = np.zeros(d)
    gain[0] = task["acceleration"] * period

    forces = rng.normal(0, 50, (2, len(h), layout.legs, d)) * stance[..., None]
    velocity = rng.normal(0, 0.3, d) + np.eye(d)[0] * task.speed
    wanted = turn @ (velocity + gain) - velocity - period * body.gravity
    given = (h[:, None, None] * forces.mean(axis=0)).sum(axis=(0, 1)) / body.mass
    forces += (wanted - given) * body.mass / (h @ stance.sum(axis=1)) * stance[..., None]
    first, last = body.acceleration(forces)
    gained = np.vstack([np.zeros(d), np.cumsum(h[:, None] * (first + last) / 2, axis=0)])
    fallen = h[:, None] * gained[:-1] + h[:, None] ** 2 * (first / 3 + last / 6)
    position = rng.normal(0, 0.05, d) + np.eye(d)[-1] * 0.5
    if task["yaw_rate"]:
        way = velocity * period + fallen.sum(axis=0)
        position[:2] = np.linalg.solve(turn[:2, :2] - np.eye(2), way[:2] - shift[:2])
        velocity[2] = -fallen[:, 2].sum() / period
    else:
        velocity = (shift - fallen.sum(axis=0)) / period
    velocities = velocity + gained
    positions = position + np.vstack([np.zeros(d), np.cumsum(h[:, None] * velocity + fallen, axis=0)])

    angles = rng.normal(0, 0.2, (len(times), layout.angles))
    omega = rng.normal(0, 0.5, (len(times), layout.angles))
    angles[-1], omega[-1] = angles[0], omega[0]
    if d == 3:
        angles[:, 0] += task["yaw_rate"] * times
    feet = _feet(rng, body.default_feet, stance, turn, shift)
    return Trajectory(
        times=times,
        base=np.hstack([positions, angles, velocities, omega]),
        feet=feet,
        forces=forces[0],
        end_forces=forces[1],
        foot_velocities=np.diff(feet, axis=0) / h[:, None, None],
        durations=durations,
    )


def _step(task: Task, d: int) -> tuple[Array, Array]:
    """The turn [d, d] and the displacement [d] of a cycle."""
    turn, shift = np.eye(d), np.zeros(d)
    moved = displacements(task, np.array(task.cycle_duration))
    if d == 2:
        shift[0] = moved[0]
        return turn, shift
    angle = task["yaw_rate"] * task.cycle_duration
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    shift[:2] = moved
    return turn, shift


def _feet(rng: np.random.Generator, default: Array, stance: Array, turn: Array, shift: Array) -> Array:
    """Feet [K + 1, legs, d] that stand still in stance, on the ground, and are anywhere above it in swing."""
    steps, legs = stance.shape
    feet = default + rng.normal(0, 0.1, (steps + 1, legs, default.shape[1]))
    feet[..., -1] = rng.uniform(0.02, 0.1, (steps + 1, legs))
    for leg, stands in enumerate(stance.T):
        if stands.all():
            feet[:, leg], feet[:, leg, -1] = feet[0, leg], 0.0
            continue
        first = int(np.flatnonzero(~stands)[0]) + 1  # a knot before which the leg swings
        foot = feet[0, leg]
        for knot in range(first, first + steps):
            if not stands[(knot - 1) % steps]:
                foot = feet[knot % steps, leg].copy()
                foot[-1] *= not stands[knot % steps]
                foot = turn @ foot + shift if knot >= steps else foot
            feet[knot % steps, leg] = turn.T @ (foot - shift) if knot >= steps else foot
        feet[steps, leg] = turn @ feet[0, leg] + shift
    return feet
