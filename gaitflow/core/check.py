"""Is this trajectory feasible? An independent check, in numpy, that shares no code with the transcription.

It reads the physical constants from the scenario's JSON and the stored trajectory in SI units, recomputes eq. (3)-(7)
from scratch, and reports the worst violation of each kind, scaled: forces over m g, lengths per metre, velocities per
m/s, times over T. Solver success means this check, never a solver's status.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from gaitflow.core.trajectory import Array, Trajectory

FEASIBLE = 1e-6
_G = 9.81


def worst(
    scenario: Mapping[str, Any], trajectory: Trajectory, speed: float, cycle_duration: float, pattern: str
) -> float:
    """The largest of `violations`; feasible means at most FEASIBLE."""
    return max(violations(scenario, trajectory, speed, cycle_duration, pattern).values())


def violations(
    scenario: Mapping[str, Any], trajectory: Trajectory, speed: float, cycle_duration: float, pattern: str
) -> dict[str, float]:
    """Worst scaled violation by kind; inf for a trajectory with a NaN.

    `scenario` is `Scenario.as_data()`; `speed` v in m/s, `cycle_duration` T in s; `pattern` as solved, "0110/1100".
    """
    robot, settings = scenario["robot"], scenario["transcription"]
    if not all(np.isfinite(getattr(trajectory, field.name)).all() for field in fields(Trajectory)):
        return {"not a number": math.inf}
    d = int(robot["dimension"])
    n = int(settings["knots_per_phase"])
    weight = float(robot["mass"]) * _G
    h = np.repeat(trajectory.durations / n, n)
    stance = np.repeat(np.array([[int(c) for c in row] for row in pattern.split("/")], dtype=bool).T, n, axis=0)
    forces, feet, velocities = trajectory.forces, trajectory.feet, trajectory.foot_velocities
    normal, tangent = forces[..., -1], forces[..., :-1]
    moved = np.diff(feet, axis=0)
    advance = np.zeros(trajectory.base.shape[1])
    advance[0] = speed * cycle_duration
    foot_advance = np.zeros(d)
    foot_advance[0] = speed * cycle_duration
    friction = float(scenario["terrain"]["friction"])
    shortest = float(settings["min_phase_fraction"]) * cycle_duration
    tilt = trajectory.base[:, d : d + (1 if d == 2 else 3)]
    return {
        "dynamics": _largest(_base_defects(scenario, trajectory, h)),
        "foot motion": _largest(moved - h[:, None, None] * velocities),
        "periodicity": max(
            _largest(trajectory.base[-1] - trajectory.base[0] - advance),
            _largest(feet[-1] - feet[0] - foot_advance),
        ),
        "kinematic box": _excess(np.abs(_offsets(robot, trajectory)) - np.array(robot["box"])),
        "friction": _excess(np.abs(tangent) - friction * normal[..., None]) / weight,
        "unilaterality": _excess(-normal) / weight,
        "force limit": _excess(normal - float(robot["max_force"])) / weight,
        "penetration": _excess(-feet[..., -1]),
        "force in swing": _largest(forces[~stance]) / weight,
        "slip in stance": _largest(moved[stance]),
        "lift in stance": max(_largest(feet[:-1][stance][..., -1]), _largest(feet[1:][stance][..., -1])),
        "foot speed": _excess(np.abs(velocities) - float(robot["max_foot_speed"])),
        "tilt": _excess(np.abs(tilt) - float(robot["max_tilt"])),
        "cycle": abs(float(trajectory.durations.sum()) - cycle_duration) / cycle_duration,
        "clock": _largest(np.diff(trajectory.times, prepend=0.0) - np.append(0.0, h)) / cycle_duration,
        "phase duration": _excess(shortest - trajectory.durations) / cycle_duration,
    }


def step_gaps(scenario: Mapping[str, Any], trajectory: Trajectory, substeps: int = 20) -> Array:
    """How far each stored step is from the continuous motion under the same forces, [K, nb].

    Every step is integrated anew from its stored knot with `substeps` Runge-Kutta steps and the forces held; the feet
    move as stored. This is the error *between* knots that a feasible discrete solution does not see.
    """
    n = int(scenario["transcription"]["knots_per_phase"])
    h = np.repeat(trajectory.durations / n, n)
    fine = _advance(scenario, trajectory, h, _runge_kutta, substeps)
    return np.asarray(trajectory.base[1:] - fine)


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _excess(values: Array) -> float:
    return max(0.0, float(np.max(values, initial=0.0)))


def _base_defects(scenario: Mapping[str, Any], trajectory: Trajectory, h: Array) -> Array:
    rule = _euler if scenario["transcription"]["integrator"] == "euler" else _runge_kutta
    return np.asarray(trajectory.base[1:] - _advance(scenario, trajectory, h, rule, 1))


_Rate = Callable[[Array, Array], Array]


def _advance(
    scenario: Mapping[str, Any],
    trajectory: Trajectory,
    h: Array,
    rule: Callable[[_Rate, Array, Array, Array, Array], tuple[Array, Array]],
    substeps: int,
) -> Array:
    """Base state [K, nb] after each step, started from the stored knots."""
    base, feet = trajectory.base[:-1], trajectory.feet[:-1]
    dt = h[:, None] / substeps

    def rate(state: Array, foot: Array) -> Array:
        return _base_rate(scenario, state, foot, trajectory.forces)

    for _ in range(substeps):
        base, feet = rule(rate, base, feet, trajectory.foot_velocities, dt)
    return base


def _euler(rate: _Rate, base: Array, feet: Array, velocity: Array, dt: Array) -> tuple[Array, Array]:
    return base + dt * rate(base, feet), feet + dt[..., None] * velocity


def _runge_kutta(rate: _Rate, base: Array, feet: Array, velocity: Array, dt: Array) -> tuple[Array, Array]:
    half, full = feet + dt[..., None] / 2 * velocity, feet + dt[..., None] * velocity
    k1 = rate(base, feet)
    k2 = rate(base + dt / 2 * k1, half)
    k3 = rate(base + dt / 2 * k2, half)
    k4 = rate(base + dt * k3, full)
    return base + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4), full


def _base_rate(scenario: Mapping[str, Any], state: Array, feet: Array, forces: Array) -> Array:
    """Eq. (4) for all steps at once: d/dt of the base state [K, nb]."""
    robot = scenario["robot"]
    inertia = np.array(robot["inertia"], dtype=float)
    slope = math.radians(float(scenario["terrain"]["slope_deg"]))
    if robot["dimension"] == 2:
        lever = feet - state[:, None, :2]
        moments = (lever[..., 0] * forces[..., 1] - lever[..., 1] * forces[..., 0]).sum(axis=1)
        acceleration = forces.sum(axis=1) / robot["mass"] - _G * np.array([math.sin(slope), math.cos(slope)])
        return np.column_stack([state[:, 3:5], state[:, 5], acceleration, moments / inertia[0, 0]])
    omega = state[:, 9:12]
    moments = np.cross(feet - state[:, None, :3], forces).sum(axis=1)
    in_base = np.einsum("kij,kj->ki", _rotations(state[:, 3:6]), moments)
    momentum = omega @ inertia.T
    spin = np.linalg.solve(inertia, (in_base - np.cross(omega, momentum)).T).T
    acceleration = forces.sum(axis=1) / robot["mass"] - _G * np.array([math.sin(slope), 0.0, math.cos(slope)])
    return np.column_stack([state[:, 6:9], _euler_rates(state[:, 3:6], omega), acceleration, spin])


def _offsets(robot: Mapping[str, Any], trajectory: Trajectory) -> Array:
    """Feet relative to their default places in the base frame [K+1, legs, d]."""
    default = np.array([leg["default_foot"] for leg in robot["legs"]])
    if robot["dimension"] == 2:
        c, s = np.cos(trajectory.base[:, 2]), np.sin(trajectory.base[:, 2])
        rotation = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=-2)
        lever = trajectory.feet - trajectory.base[:, None, :2]
    else:
        rotation = _rotations(trajectory.base[:, 3:6])
        lever = trajectory.feet - trajectory.base[:, None, :3]
    return np.asarray(np.einsum("kij,klj->kli", rotation, lever) - default)


def _rotations(angles: Array) -> Array:
    """World to base [K, 3, 3] from (yaw, pitch, roll), as a product of three elementary rotations."""

    def about(axis: int, angle: Array) -> Array:
        matrix = np.zeros((len(angle), 3, 3))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix[:, axis, axis] = 1
        matrix[:, i, i] = matrix[:, j, j] = np.cos(angle)
        matrix[:, j, i], matrix[:, i, j] = np.sin(angle), -np.sin(angle)
        return matrix

    to_world = about(2, angles[:, 0]) @ about(1, angles[:, 1]) @ about(0, angles[:, 2])
    return np.asarray(to_world.transpose(0, 2, 1))


def _euler_rates(angles: Array, omega: Array) -> Array:
    """Rates of (yaw, pitch, roll) from the body rates, by inverting omega = E(angles) rates."""
    pitch, roll = angles[:, 1], angles[:, 2]
    matrix = np.zeros((len(angles), 3, 3))
    matrix[:, 0, 0], matrix[:, 0, 2] = -np.sin(pitch), 1
    matrix[:, 1, 0], matrix[:, 1, 1] = np.cos(pitch) * np.sin(roll), np.cos(roll)
    matrix[:, 2, 0], matrix[:, 2, 1] = np.cos(pitch) * np.cos(roll), -np.sin(roll)
    return np.asarray(np.linalg.solve(matrix, omega[..., None])[..., 0])
