"""Is this trajectory feasible, and what does it cost? An independent check in numpy.

It shares no code with the transcription: it reads the physical constants from the scenario's JSON and the stored
trajectory in SI units, recomputes eq. (3)-(7) from scratch, and reports the worst violation of each kind, scaled:
forces over m g, lengths per metre, velocities per m/s, times over T. Solver success means this check, never a solver's
status. What happens between the knots, and the cost, are in `gaitflow.core.continuous`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.continuous import Motion, between_knots, cost, seen_from_frame, step_gaps, step_shares
from gaitflow.core.joints import Joints
from gaitflow.core.rigid_body import Attitude, RigidBody, moment
from gaitflow.core.swing_reach import reach_excess
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory

__all__ = ["FEASIBLE", "between_knots", "cost", "step_gaps", "violations", "worst"]

FEASIBLE = 1e-6

Mask = NDArray[np.bool_]


def worst(scenario: Mapping[str, Any], trajectory: Trajectory, task: Task, pattern: str) -> float:
    """The largest of `violations`; feasible means at most FEASIBLE."""
    return max(violations(scenario, trajectory, task, pattern).values())


def violations(scenario: Mapping[str, Any], trajectory: Trajectory, task: Task, pattern: str) -> dict[str, float]:
    """Worst scaled violation by kind; inf for arrays of other shapes than the scenario's, NaN, and what overflows.

    `scenario` is `Scenario.as_data()`; `pattern` as solved, "0110/1100". Raises ValueError for a pattern of another
    shape than the scenario's.
    """
    robot, settings = scenario["robot"], scenario["transcription"]
    stance = _stance(pattern, len(robot["legs"]), int(settings["phases"]), int(settings["knots_per_phase"]))
    if _shapes(trajectory) != _expected_shapes(robot, settings):
        return {"shape": math.inf}
    if not all(np.isfinite(getattr(trajectory, field.name)).all() for field in fields(Trajectory)):
        return {"not a number": math.inf}
    with np.errstate(all="ignore"):
        found = _found(scenario, trajectory, task, stance)
        if scenario.get("swing_clearance") and Joints.of(scenario) is not None:
            body = RigidBody.of(scenario["robot"], task)
            found["swing reach"] = reach_excess(scenario, body, trajectory, task, pattern)
    return {kind: math.inf if math.isnan(value) else value for kind, value in found.items()}


def _found(scenario: Mapping[str, Any], trajectory: Trajectory, task: Task, stance: Mask) -> dict[str, float]:
    """The violations of finite arrays of the right shapes; NaN where numbers were too large."""
    robot, settings = scenario["robot"], scenario["transcription"]
    n, linear = int(settings["knots_per_phase"]), settings.get("forces", "held") == "linear"
    body = RigidBody.of(robot, task)
    weight, cycle = body.weight, task.cycle_duration
    shares = step_shares(settings)
    h = (trajectory.durations[:, None] * shares).ravel()
    base, feet, velocities = trajectory.base, trajectory.feet, trajectory.foot_velocities
    position, angles, _, _ = body.split(base)
    forces = np.stack([trajectory.forces, trajectory.end_forces])
    normal, moved = forces[..., -1], np.diff(feet, axis=0)
    limited = angles[:, 1:] if body.dimension == 3 and _varies(scenario, "yaw_rate") else angles
    box = _largest_of(body.box_excess(position, angles, feet))
    if settings["integrator"] != "euler":
        box = max(box, _box_in_the_middle(body, trajectory, h))
    reached = np.append(0.0, np.cumsum(h))
    at = np.stack([reached[:-1], reached[1:]]) if linear else np.stack([reached[:-1] + h / 2] * 2)
    tangent = seen_from_frame(forces, at, task)[..., :-1]
    fastest = float(robot["max_foot_speed"])
    closing = _closing(body, trajectory, task)
    lift = float(-body.default_feet[:, -1].min() + body.box[-1])
    asked = {"swing clearance": _low_swings(scenario, feet, stance)} if scenario.get("swing_clearance") else {}
    return asked | {
        "dynamics": _largest(_base_defects(str(settings["integrator"]), body, trajectory, h)),
        "foot motion": _largest(moved - h[:, None, None] * velocities),
        "periodicity": closing,
        "kinematic box": max(0.0, box),
        "friction": _excess(np.abs(tangent) - task["friction"] * normal[..., None]) / weight,
        "unilaterality": _excess(-normal) / weight,
        "force limit": _excess(normal - float(robot["max_force"])) / weight,
        "force course": _largest(_off_course(trajectory, n, linear)) / weight,
        "penetration": _excess(-feet[..., -1]),
        "foot height": _excess(feet[..., -1] - lift),
        "force in swing": _largest(forces[:, ~stance]) / weight,
        "slip in stance": _largest(moved[stance]),
        "lift in stance": max(_largest(feet[:-1][stance][..., -1]), _largest(feet[1:][stance][..., -1])),
        "foot speed": _excess(np.abs(seen_from_frame(velocities, reached[:-1] + h / 2, task)) - fastest),
        "tilt": _excess(np.abs(limited) - float(robot["max_tilt"])),
        "cycle": abs(float(trajectory.durations.sum()) - cycle) / cycle,
        "clock": max(abs(float(trajectory.times[0])), _largest(np.diff(trajectory.times) - h)) / cycle,
        "phase duration": _excess(float(settings["min_phase_fraction"]) * cycle - trajectory.durations) / cycle,
    }


def _stance(pattern: str, legs: int, phases: int, knots_per_phase: int) -> Mask:
    """Which leg stands in which step [K, legs]."""
    rows = pattern.split("/")
    if len(rows) != legs or any(len(row) != phases or row.strip("01") for row in rows):
        raise ValueError(f"pattern {pattern[:80]!r}: the scenario has {legs} legs and {phases} phases")
    return np.repeat(np.array([[digit == "1" for digit in row] for row in rows]).T, knots_per_phase, axis=0)


def _low_swings(scenario: Mapping[str, Any], feet: Array, stance: Mask) -> float:
    """How much [m] a foot is too low in the middle of a swing."""
    wanted, low = float(scenario["swing_clearance"]), 0.0
    for leg in range(stance.shape[1]):
        begins = np.flatnonzero(~stance[:, leg] & np.roll(stance[:, leg], 1))
        for begin in begins:
            length = int(np.argmax(np.roll(stance[:, leg], -begin)))
            knots = begin + np.array([length // 2, (length + 1) // 2])
            low = max(low, wanted - float(feet[knots % len(stance), leg, -1].min()))
    return low


def _shapes(trajectory: Trajectory) -> list[tuple[int, ...]]:
    return [np.shape(getattr(trajectory, field.name)) for field in fields(Trajectory)]


def _expected_shapes(robot: Mapping[str, Any], settings: Mapping[str, Any]) -> list[tuple[int, ...]]:
    d, legs, phases = int(robot["dimension"]), len(robot["legs"]), int(settings["phases"])
    steps = phases * int(settings["knots_per_phase"])
    controls = (steps, legs, d)
    base = 2 * (d + (1 if d == 2 else 3))
    return [(steps + 1,), (steps + 1, base), (steps + 1, legs, d), controls, controls, controls, (phases,)]


def _varies(scenario: Mapping[str, Any], axis: str) -> bool:
    """Whether a scenario gives an axis a range, or a value that is not 0."""
    value = scenario["tasks"]["axes"].get(axis, 0.0)
    return isinstance(value, Mapping) or value != 0


def _off_course(trajectory: Trajectory, n: int, linear: bool) -> Array:
    """What a force differs from the course it may take: held over a step, or linear without jumps within a phase."""
    if not linear:
        return trajectory.end_forces - trajectory.forces
    inside = np.arange(len(trajectory.forces) - 1) % n != n - 1
    return (trajectory.forces[1:] - trajectory.end_forces[:-1])[inside]


def _closing(body: RigidBody, trajectory: Trajectory, task: Task) -> float:
    """How far the last knot is from the first one moved by the commanded twist; eq. (3) for any twist.

    In the complex plane of (x, y), the twist's exponential is a turn by w T and a displacement (v + i v_y) T
    (exp(i w T) - 1) / (i w T).
    """
    cycle, d = task.cycle_duration, body.dimension
    angle = task["yaw_rate"] * cycle
    turn = complex(math.cos(angle), math.sin(angle))
    mean = (turn - 1) / (1j * angle) if abs(angle) > 1e-6 else 1 + 0.5j * angle
    shift = complex(task["speed"], task["lateral_speed"]) * cycle * mean
    gain = task["acceleration"] * cycle

    def difference(first: Array, last: Array, before: float, after: complex) -> float:
        """Of vectors [..., d] that are raised along x, turned, and moved."""
        if d == 2:
            along = np.abs(last[..., 0] - first[..., 0] - before - after.real)
        else:
            ground = turn * (first[..., 0] + before + 1j * first[..., 1]) + after
            error = last[..., 0] + 1j * last[..., 1] - ground
            along = np.maximum(np.abs(error.real), np.abs(error.imag))
        return max(_largest(along), _largest(last[..., -1] - first[..., -1]))

    first, last = body.split(trajectory.base[0]), body.split(trajectory.base[-1])
    turned = first[1] + np.array([angle, 0.0, 0.0]) if d == 3 else first[1]
    return max(
        difference(first[0], last[0], 0.0, shift),
        _largest(last[1] - turned),
        difference(first[2], last[2], gain, 0j),
        _largest(last[3] - first[3]),
        difference(trajectory.feet[0], trajectory.feet[-1], 0.0, shift),
    )


def _box_in_the_middle(body: RigidBody, trajectory: Trajectory, h: Array) -> float:
    """Eq. (5) in the middle of each step, on the cubic through both knots; feet move linearly."""
    position, angles, velocity, omega = body.split(trajectory.base)
    rates = Attitude(angles).rates(omega)
    eighth = h[:, None] / 8
    feet = (trajectory.feet[:-1] + trajectory.feet[1:]) / 2
    middle = [
        (value[:-1] + value[1:]) / 2 + eighth * (rate[:-1] - rate[1:])
        for value, rate in ((position, velocity), (angles, rates))
    ]
    return _largest_of(body.box_excess(middle[0], middle[1], feet))


def _base_defects(integrator: str, body: RigidBody, trajectory: Trajectory, h: Array) -> Array:
    """What the scenario's integrator leaves over in each step [K, nb]."""
    dt = h[:, None]
    start, end = trajectory.base[:-1], trajectory.base[1:]
    if integrator == "euler":
        return end - start - dt * body.rate(start, trajectory.feet[:-1], trajectory.forces)
    if integrator == "momentum":
        return _momentum_defects(body, trajectory, dt)
    feet = (trajectory.feet[:-1] + trajectory.feet[1:]) / 2
    forces = (trajectory.forces + trajectory.end_forces) / 2
    if integrator == "midpoint":
        return end - start - dt * body.rate((start + end) / 2, feet, forces)
    first = body.rate(start, trajectory.feet[:-1], trajectory.forces)
    if integrator == "hermite_simpson":
        last = body.rate(end, trajectory.feet[1:], trajectory.end_forces)
        middle = body.rate((start + end) / 2 + dt / 8 * (first - last), feet, forces)
        return end - start - dt / 6 * (first + 4 * middle + last)
    if integrator == "rk4":
        second = body.rate(start + dt / 2 * first, feet, forces)
        third = body.rate(start + dt / 2 * second, feet, forces)
        last = body.rate(start + dt * third, trajectory.feet[1:], trajectory.end_forces)
        return end - start - dt / 6 * (first + 2 * second + 2 * third + last)
    raise ValueError(f"integrator {integrator[:80]!r} is unknown to the check")


def _momentum_defects(body: RigidBody, trajectory: Trajectory, dt: Array) -> Array:
    """Of the step that is exact in momentum.

    The acceleration runs linearly, so velocity and position are polynomials from the start; so is the impulse of moment
    about the origin and, in the plane, the turn. In space the angles' rates count with their derivatives at both ends.
    """
    base, feet = trajectory.base, trajectory.feet
    ends = np.stack([base[:-1], base[1:]])
    both_feet, forces = np.stack([feet[:-1], feet[1:]]), np.stack([trajectory.forces, trajectory.end_forces])
    position, angles, velocity, omega = body.split(ends)
    attitude = Attitude(angles)
    a0, a1 = body.acceleration(forces)
    rates = attitude.rates(omega)
    second = attitude.accelerations(omega, body.spin(ends, both_feet, forces, attitude))
    turned = dt / 2 * (rates[0] + rates[1]) + dt**2 / 12 * (second[0] - second[1])
    if body.dimension == 2:
        turned = Motion(body, trajectory, dt[:, 0]).planar_turn()
    path = dt * position[0] + dt**2 / 2 * velocity[0] + dt**3 * (a0 / 8 + a1 / 24)
    pressed = moment(both_feet[0], 2 * forces[0] + forces[1]) + moment(both_feet[1], forces[0] + 2 * forces[1])
    impulse = dt / 6 * pressed.sum(axis=-2) + body.mass * moment(path, body.gravity)
    gained = np.diff(body.angular_momentum(base), axis=0)
    return np.concatenate(
        [
            position[1] - position[0] - dt * velocity[0] - dt**2 * (a0 / 3 + a1 / 6),
            angles[1] - angles[0] - turned,
            velocity[1] - velocity[0] - dt / 2 * (a0 + a1),
            (gained - impulse) / (np.trace(body.inertia) / body.angles),
        ],
        axis=-1,
    )


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _largest_of(values: Array) -> float:
    return float(values.max(initial=-math.inf))


def _excess(values: Array) -> float:
    return max(0.0, float(values.max(initial=0.0)))
