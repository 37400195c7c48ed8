"""Where each state, control and duration sits in the decision vector w, and its scale.

w = (x_0, u_0, x_1, u_1, ..., x_K, end forces, fractions, contacts): states x_k at the K+1 knots, controls u_k of the
step from knot k to k+1, the forces at the end of each phase where forces are linear, the phase durations as fractions
of the cycle, and, where the objective is energy, which leg stands in which phase, which a pattern fixes. The paper's
settings give 41*10 + 40*8 + 4 = 734 in the plane and 41*24 + 40*24 + 4 = 1948 in space.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gaitflow.core.trajectory import Array, Trajectory

GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Layout:
    """Sizes and index arithmetic; `weight` m*g [N] is the scale of a force, everything else is in SI units.

    x = (position d, angles a, velocity d, angular velocity a, feet legs*d); u = (forces legs*d, foot velocities
    legs*d); legs in the robot's order, coordinates fastest. `linear_forces`: a force runs linearly within a step, from
    its value at the step's start to that at the start of the next one; the last of a phase has a value of its own.
    `grading` from 0 (equal steps) to 1 (spaced by a cosine): how much finer knots are at the ends of a phase.
    """

    dimension: int
    legs: int
    phases: int
    knots_per_phase: int
    weight: float
    linear_forces: bool = False
    grading: float = 0.0
    energy: bool = False

    @classmethod
    def of(cls, scenario: Mapping[str, Any]) -> Layout:
        """The layout of a scenario's JSON data (`Scenario.as_data`)."""
        robot, transcription, objective = scenario["robot"], scenario["transcription"], scenario.get("objective", {})
        return cls(
            dimension=int(robot["dimension"]),
            legs=len(robot["legs"]),
            phases=int(transcription["phases"]),
            knots_per_phase=int(transcription["knots_per_phase"]),
            weight=float(robot["mass"]) * GRAVITY,
            linear_forces=transcription.get("forces", "held") == "linear",
            grading=float(transcription.get("grading", 0.0)),
            energy=bool(objective.get("joint_heat") or objective.get("joint_work")),
        )

    @property
    def angles(self) -> int:
        """Number of base angles a: 1 (pitch) in the plane, 3 (yaw, pitch, roll) in space."""
        return 1 if self.dimension == 2 else 3

    @property
    def nb(self) -> int:
        """Size of the base state."""
        return 2 * (self.dimension + self.angles)

    @property
    def nx(self) -> int:
        """Size of the state at a knot."""
        return self.nb + self.legs * self.dimension

    @property
    def nu(self) -> int:
        """Size of the control of a step."""
        return 2 * self.legs * self.dimension

    @property
    def steps(self) -> int:
        """Number of steps K; there are K+1 knots."""
        return self.phases * self.knots_per_phase

    @property
    def nw(self) -> int:
        """Number of continuous decision variables."""
        return self.fractions.stop + (self.legs * self.phases if self.energy else 0)

    @property
    def _end_forces(self) -> int:
        return (self.steps + 1) * self.nx + self.steps * self.nu

    @cached_property
    def shares(self) -> Array:
        """What part of its phase each step lasts [knots_per_phase]; they sum to 1."""
        even = np.linspace(0.0, 1.0, self.knots_per_phase + 1)
        cosine = (1 - np.cos(np.pi * even)) / 2
        shares: Array = np.diff((1 - self.grading) * even + self.grading * cosine)
        return shares

    def phase_of(self, step: int) -> int:
        """Phase of a step (every phase has equally many)."""
        return step // self.knots_per_phase

    def state(self, knot: int) -> slice:
        """Slice of w that holds x_knot."""
        start = knot * (self.nx + self.nu)
        return slice(start, start + self.nx)

    def control(self, step: int) -> slice:
        """Slice of w that holds u_step."""
        start = step * (self.nx + self.nu) + self.nx
        return slice(start, start + self.nu)

    @property
    def fractions(self) -> slice:
        """Slice of w that holds the phase durations over T."""
        ends = self.phases * self.legs * self.dimension if self.linear_forces else 0
        start = self._end_forces + ends
        return slice(start, start + self.phases)

    def contacts(self, leg: int) -> slice:
        """Slice of w that holds in which phases a leg stands, 1, or swings, 0; where the objective is energy."""
        start = self.fractions.stop + leg * self.phases
        return slice(start, start + self.phases)

    def foot(self, knot: int, leg: int) -> slice:
        """Slice of w that holds the position of a foot."""
        start = self.state(knot).start + self.nb + leg * self.dimension
        return slice(start, start + self.dimension)

    def force(self, step: int, leg: int) -> slice:
        """Slice of w that holds the force on a foot at the start of a step."""
        start = self.control(step).start + leg * self.dimension
        return slice(start, start + self.dimension)

    def end_force(self, step: int, leg: int) -> slice:
        """Slice of w that holds the force on a foot at the end of a step: the same one where forces are held."""
        if not self.linear_forces:
            return self.force(step, leg)
        if (step + 1) % self.knots_per_phase:
            return self.force(step + 1, leg)
        start = self._end_forces + (self.phase_of(step) * self.legs + leg) * self.dimension
        return slice(start, start + self.dimension)

    def foot_velocity(self, step: int, leg: int) -> slice:
        """Slice of w that holds the velocity of a foot."""
        start = self.control(step).start + (self.legs + leg) * self.dimension
        return slice(start, start + self.dimension)

    @cached_property
    def _units(self) -> Array:
        units = np.ones(self.nw)
        half = self.legs * self.dimension
        for step in range(self.steps):
            start = self.control(step).start
            units[start : start + half] = self.weight
        units[self._end_forces : self.fractions.start] = self.weight
        return units

    def scale(self, cycle_duration: float) -> Array:
        """Factors [nw] that turn w into SI units: m*g for forces, T for durations, 1 for the rest."""
        scale = self._units.copy()
        scale[self.fractions] = cycle_duration
        return scale

    def times(self, durations: Array) -> Array:
        """Times [K+1] of the knots for phase durations [phases], in their unit."""
        steps = (np.asarray(durations)[:, None] * self.shares).ravel()
        return np.concatenate([[0.0], np.cumsum(steps)])

    def unpack(self, w: Array, cycle_duration: float) -> Trajectory:
        """Trajectory in SI units from the scaled decision vector w [nw]."""
        si = np.asarray(w, dtype=float) * self.scale(cycle_duration)
        steps, d, stride = self.steps, self.dimension, self.nx + self.nu
        body = si[: steps * stride].reshape(steps, stride)
        states = np.append(body[:, : self.nx].ravel(), si[self.state(steps)]).reshape(steps + 1, self.nx)
        forces, velocities = np.split(body[:, self.nx :].reshape(steps, 2 * self.legs, d), 2, axis=1)
        ends = forces
        if self.linear_forces:
            last = si[self._end_forces : self.fractions.start].reshape(self.phases, self.legs, d)
            ends = np.roll(forces, -1, axis=0)
            ends[self.knots_per_phase - 1 :: self.knots_per_phase] = last
        durations = si[self.fractions]
        return Trajectory(
            times=self.times(durations),
            base=states[:, : self.nb].copy(),
            feet=states[:, self.nb :].reshape(steps + 1, self.legs, d).copy(),
            forces=forces.copy(),
            end_forces=ends.copy(),
            foot_velocities=velocities.copy(),
            durations=durations.copy(),
        )

    def pack(self, trajectory: Trajectory, cycle_duration: float, pattern: str | None = None) -> Array:
        """The scaled decision vector w [nw] of a trajectory; the inverse of `unpack`.

        Contacts, where w has them, are those of the pattern, "0110/1100", and 0 without one.
        """
        knots, steps = self.steps + 1, self.steps
        states = np.hstack([trajectory.base, trajectory.feet.reshape(knots, -1)])
        controls = np.hstack([trajectory.forces.reshape(steps, -1), trajectory.foot_velocities.reshape(steps, -1)])
        parts = [np.hstack([states[:-1], controls]).ravel(), states[-1]]
        if self.linear_forces:
            parts.append(trajectory.end_forces[self.knots_per_phase - 1 :: self.knots_per_phase].ravel())
        contacts = np.zeros(self.nw - self.fractions.stop)
        if pattern is not None and self.energy:
            contacts[:] = [float(digit) for row in pattern.split("/") for digit in row]
        return np.concatenate([*parts, trajectory.durations, contacts]) / self.scale(cycle_duration)
