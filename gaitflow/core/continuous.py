"""The motion between the knots of a trajectory, what it costs, and what it violates there; part of the check.

Within a step forces and feet run linearly in time. So the acceleration is linear, the centre of mass follows a cubic,
and the angular momentum about the world's origin is a polynomial: all exact. Only the orientation is integrated, from
the exact angular momentum about the centre of mass, on a fine grid. Each step starts anew from its stored knot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gaitflow.core.force_rate import force_rate
from gaitflow.core.joints import Joints
from gaitflow.core.rigid_body import Attitude, RigidBody, moment
from gaitflow.core.swing_reaction import swing_reaction
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory

FINER = 10  # substeps of a step where the motion between knots is looked at
GAUSS_POINTS = 5  # of a step where the cost is integrated


def cost(scenario: Mapping[str, Any], trajectory: Trajectory, task: Task, pattern: str | None = None) -> float:
    """The objective, eq. (8)-(10), in the scenario's units, in the frame that follows the task's twist.

    Integrated along the motion between the knots; with the integrator `euler` it is the paper's sum over the knots.
    Energy asks for the pattern, "0110/1100", too, which says how long legs swing. Raises ValueError without it.
    """
    motion = Motion.of(scenario, trajectory, task)
    if scenario["transcription"]["integrator"] == "euler":
        fractions, weights = np.zeros(1), np.ones(1)
    else:
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        fractions, weights = (nodes + 1) / 2, weights / 2
    seen = motion.at(fractions)
    integrands = _integrand(scenario["objective"], motion.body, seen, task)
    joints, swings = Joints.of(scenario), 0.0
    if joints is not None:
        if pattern is None:
            raise ValueError("the cost of an objective of energy needs the pattern as well")
        integrands += _watts(joints, motion.body, seen)
        swinging = np.array([[digit == "0" for digit in row] for row in pattern.split("/")])
        swings = joints.swings(task, swinging @ trajectory.durations, float(scenario.get("swing_clearance", 0.0)))
        if reaction := float(scenario["objective"].get("swing_reaction", 0.0)):
            swings += reaction * swing_reaction(joints, task, trajectory.durations, pattern)
    rates = float(scenario["objective"].get("force_rate", 0.0)) * force_rate(trajectory, motion.h, task)
    return float(weights @ integrands @ motion.h) + swings + rates


def between_knots(
    scenario: Mapping[str, Any], trajectory: Trajectory, task: Task, pattern: str, finer: int = FINER
) -> dict[str, float]:
    """Worst violations on a grid `finer` times finer than the steps, 0 where there is none.

    dynamics: largest distance of base position [m] or angles [rad] from the next stored knot; kinematic box [m];
    friction of the legs that stand, over m g; penetration [m].
    """
    motion = Motion.of(scenario, trajectory, task)
    body = motion.body
    seen = motion.at(np.arange(finer + 1) / finer)
    positions = body.dimension + body.angles
    gaps = trajectory.base[1:, :positions] - seen.base[-1][:, :positions]
    phases = np.array([[digit == "1" for digit in row] for row in pattern.split("/")]).T
    stance = np.repeat(phases, len(motion.h) // len(phases), axis=0)
    normal = seen.forces[..., -1:]
    tangent = seen_from_frame(seen.forces, seen.times, task)[..., :-1]
    slip = (np.abs(tangent) - task["friction"] * normal)[:, stance]
    position, angles, _, _ = body.split(seen.base)
    return {
        "dynamics": float(np.abs(gaps).max()),
        "kinematic box": max(0.0, float(body.box_excess(position, angles, seen.feet).max())),
        "friction": max(0.0, float(slip.max(initial=0.0))) / body.weight,
        "penetration": max(0.0, float(-seen.feet[..., -1].min())),
    }


def step_gaps(scenario: Mapping[str, Any], trajectory: Trajectory, task: Task) -> Array:
    """How far each stored step is from the continuous motion under the same forces, [K, nb].

    This is the error *between* knots that a feasible discrete solution does not see.
    """
    motion = Motion.of(scenario, trajectory, task)
    return np.asarray(trajectory.base[1:] - motion.at(np.arange(FINER + 1) / FINER).base[-1])


def seen_from_frame(vectors: Array, times: Array, task: Task) -> Array:
    """World vectors [..., legs, d] in the directions of the frame that follows the twist at times [...] s."""
    if vectors.shape[-1] == 2 or task["yaw_rate"] == 0:
        return vectors.copy()
    ground = np.exp(-1j * task["yaw_rate"] * times)[..., None] * (vectors[..., 0] + 1j * vectors[..., 1])
    return np.stack([ground.real, ground.imag, vectors[..., 2]], axis=-1)


def step_shares(settings: Mapping[str, Any]) -> Array:
    """What part of its phase each step lasts: a mixture of even knots and of the projections of even arcs.

    `settings` is a scenario's `transcription`.
    """
    n, grading = int(settings["knots_per_phase"]), float(settings.get("grading", 0.0))
    even = np.arange(n + 1) / n
    return np.diff((1 - grading) * even + grading * np.sin(np.pi / 2 * even) ** 2)


@dataclass(frozen=True)
class Moments:
    """A motion at n moments in each of its K steps: base [n, K, nb], feet and forces [n, K, legs, d], times [n, K]."""

    base: Array
    feet: Array
    forces: Array
    times: Array
    rates: Array  # of the angles [n, K, a]


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion within all steps at once; h [K] s are their durations. Build it with `Motion.of`."""

    body: RigidBody
    trajectory: Trajectory
    h: Array

    @classmethod
    def of(cls, scenario: Mapping[str, Any], trajectory: Trajectory, task: Task) -> Motion:
        """The motion of a trajectory of a scenario's JSON data."""
        h = (trajectory.durations[:, None] * step_shares(scenario["transcription"])).ravel()
        return cls(RigidBody.of(scenario["robot"], task), trajectory, h)

    def at(self, fractions: Array) -> Moments:
        """The motion at rising fractions [n] of every step, from 0 to 1."""
        s = np.asarray(fractions, dtype=float)
        angles = self._angles(s)
        position, velocity = self._centre(s)
        omega = self._omega(s, angles)
        base = np.concatenate([position, angles, velocity, omega], axis=-1)
        forces = self._line(self.trajectory.forces, self.trajectory.end_forces, s)
        starts = np.cumsum(self.h) - self.h
        return Moments(base, self._feet(s), forces, starts + s[:, None] * self.h, Attitude(angles).rates(omega))

    def _line(self, first: Array, last: Array, s: Array) -> Array:
        return np.asarray(first + s[:, None, None, None] * (last - first))

    def _feet(self, s: Array) -> Array:
        start = self.trajectory.feet[:-1]
        return self._line(start, start + self.h[:, None, None] * self.trajectory.foot_velocities, s)

    @cached_property
    def _accelerations(self) -> tuple[Array, Array]:
        """At the start of each step, and its change over the step [K, d]."""
        first = self.body.acceleration(self.trajectory.forces)
        return first, self.body.acceleration(self.trajectory.end_forces) - first

    def _centre(self, s: Array) -> tuple[Array, Array]:
        """Position and velocity of the centre of mass [n, K, d]."""
        position, _, velocity, _ = self.body.split(self.trajectory.base[:-1])
        first, change = self._accelerations
        h, s = self.h[:, None], s[:, None, None]
        moved = position + h * s * velocity + h**2 * (s**2 / 2 * first + s**3 / 6 * change)
        return moved, velocity + h * (s * first + s**2 / 2 * change)

    @cached_property
    def _moments(self) -> tuple[Array, Array, Array]:
        """The legs' moment about the origin in each step, as coefficients [K, a] of 1, s, s^2."""
        start = self.trajectory.feet[:-1]
        way = self.h[:, None, None] * self.trajectory.foot_velocities
        force, change = self.trajectory.forces, self.trajectory.end_forces - self.trajectory.forces
        return (
            moment(start, force).sum(axis=-2),
            (moment(start, change) + moment(way, force)).sum(axis=-2),
            moment(way, change).sum(axis=-2),
        )

    def _spin_momentum(self, s: Array) -> Array:
        """Angular momentum about the centre of mass, in world directions [n, K, a]: the origin's minus m r x v."""
        body = self.body
        base = self.trajectory.base[:-1]
        position, _, velocity, _ = body.split(base)
        first, change = self._accelerations
        m0, m1, m2 = self._moments
        h, at = self.h[:, None], s[:, None, None]
        path = at * position + h * at**2 / 2 * velocity + h**2 * (at**3 / 6 * first + at**4 / 24 * change)
        impulse = at * m0 + at**2 / 2 * m1 + at**3 / 3 * m2 + body.mass * moment(path, body.gravity)
        total = body.angular_momentum(base) + h * impulse
        return np.asarray(total - body.mass * moment(*self._centre(s)))

    def planar_turn(self) -> Array:
        """How far the body turns in each step [K, 1], in the plane: its rate is a quartic, three Gauss points exact."""
        nodes, weights = np.polynomial.legendre.leggauss(3)
        rates = self._spin_momentum((nodes + 1) / 2) @ self.body.inverse
        return np.asarray(self.h[:, None] * np.tensordot(weights / 2, rates, axes=1))

    def _omega(self, s: Array, angles: Array) -> Array:
        """Angular velocity in the base frame [n, K, a] for angles [n, K, a]."""
        momentum = self._spin_momentum(s)
        if self.body.dimension == 3:
            momentum = Attitude(angles).into_base(momentum)
        return np.asarray(momentum @ self.body.inverse)

    def _angles(self, s: Array) -> Array:
        """Angles [n, K, a]: Runge-Kutta steps from each fraction to the next, on the exact angular momentum."""
        _, angles, _, _ = self.body.split(self.trajectory.base[:-1])
        reached, found = 0.0, []
        for fraction in s:
            angles = self._turned(angles, reached, float(fraction))
            reached = float(fraction)
            found.append(angles)
        return np.stack(found)

    def _turned(self, angles: Array, start: float, stop: float) -> Array:
        """Angles [K, a] at a fraction of the step, from those at another one."""
        if stop == start:
            return angles
        momenta = self._spin_momentum(np.array([start, (start + stop) / 2, stop]))
        dt = (stop - start) * self.h[:, None]

        def rate(angles: Array, momentum: Array) -> Array:
            if self.body.dimension == 2:
                return np.asarray(momentum @ self.body.inverse)
            attitude = Attitude(angles)
            return attitude.rates(attitude.into_base(momentum) @ self.body.inverse)

        k1 = rate(angles, momenta[0])
        k2 = rate(angles + dt / 2 * k1, momenta[1])
        k3 = rate(angles + dt / 2 * k2, momenta[1])
        k4 = rate(angles + dt * k3, momenta[2])
        return np.asarray(angles + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4))


def _integrand(objective: Mapping[str, Any], body: RigidBody, seen: Moments, task: Task) -> Array:
    """The weighted integrand [n, K]."""
    _, angles, velocity, _ = body.split(seen.base)
    error = seen_from_frame(velocity[..., None, :], seen.times, task)[..., 0, :]
    error[..., 0] -= task["speed"] + task["acceleration"] * (seen.times - task.cycle_duration / 2)
    tilt, rates, lateral = angles.copy(), seen.rates.copy(), np.zeros(seen.times.shape)
    if body.dimension == 3:
        error[..., 1] -= task["lateral_speed"]
        tilt[..., 0] -= task["yaw_rate"] * seen.times
        rates[..., 0] -= task["yaw_rate"]
        origin = _origins(task, seen.times)
        feet = seen.feet - np.stack([origin.real, origin.imag, np.zeros_like(seen.times)], axis=-1)[..., None, :]
        left = seen_from_frame(feet, seen.times, task)[..., 1] - body.default_feet[:, 1]
        lateral = (left**2).sum(axis=-1)
    terms = {
        "force": (seen.forces**2).sum(axis=(-1, -2)),
        "tangential_velocity": (error[..., :-1] ** 2).sum(axis=-1),
        "normal_velocity": error[..., -1] ** 2,
        "tilt": (tilt**2).sum(axis=-1),
        "tilt_rate": (rates**2).sum(axis=-1),
        "lateral_foot": lateral,
    }
    weighted = np.zeros(seen.times.shape)
    for name, term in terms.items():
        weighted += float(objective.get(name, 0.0)) * term
    return weighted


def _watts(joints: Joints, body: RigidBody, seen: Moments) -> Array:
    """What standing legs' joints take, the integrand's part [n, K]."""
    position, angles, velocity, omega = body.split(seen.base)
    attitude = Attitude(angles)
    places = attitude.into_base(seen.feet - position[..., None, :])
    passing = -attitude.into_base(np.broadcast_to(velocity[..., None, :], places.shape))
    passing -= np.cross(omega[..., None, :], places)
    return joints.standing(places, passing, attitude.into_base(seen.forces))


def _origins(task: Task, times: Array) -> Array:
    """Where the commanded frame's origin is, x + i y [m], at times [n, K]: the integral of the turning velocity.

    By Gauss-Legendre quadrature, which needs no special case for a frame that hardly turns.
    """
    nodes, weights = np.polynomial.legendre.leggauss(12)
    velocity = complex(task["speed"], task["lateral_speed"])
    passed = times[..., None] * (nodes + 1) / 2
    return np.asarray(times * (velocity * np.exp(1j * task["yaw_rate"] * passed) @ (weights / 2)))
