"""Where each state, control and duration sits in the decision vector w, and its scale.

w = (x_0, u_0, x_1, u_1, ..., x_K, fractions): states x_k at the K+1 knots, controls u_k that act from knot k to k+1,
and the phase durations as fractions of the cycle. The paper's settings give 41*10 + 40*8 + 4 = 734 in the plane
and 41*24 + 40*24 + 4 = 1948 in space.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array, Trajectory

GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Layout:
    """Sizes and index arithmetic; `weight` m*g [N] is the scale of a force, everything else is in SI units.

    x = (position d, angles a, velocity d, angular velocity a, feet legs*d); u = (forces legs*d, foot velocities
    legs*d); legs in the robot's order, coordinates fastest.
    """

    dimension: int
    legs: int
    phases: int
    knots_per_phase: int
    weight: float

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
        return (self.steps + 1) * self.nx + self.steps * self.nu + self.phases

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
        return slice(self.nw - self.phases, self.nw)

    def foot(self, knot: int, leg: int) -> slice:
        """Slice of w that holds the position of a foot."""
        start = self.state(knot).start + self.nb + leg * self.dimension
        return slice(start, start + self.dimension)

    def force(self, step: int, leg: int) -> slice:
        """Slice of w that holds the force on a foot."""
        start = self.control(step).start + leg * self.dimension
        return slice(start, start + self.dimension)

    def foot_velocity(self, step: int, leg: int) -> slice:
        """Slice of w that holds the velocity of a foot."""
        start = self.control(step).start + (self.legs + leg) * self.dimension
        return slice(start, start + self.dimension)

    def scale(self, cycle_duration: float) -> Array:
        """Factors [nw] that turn w into SI units: m*g for forces, T for durations, 1 for the rest."""
        scale = np.ones(self.nw)
        half = self.legs * self.dimension
        for step in range(self.steps):
            start = self.control(step).start
            scale[start : start + half] = self.weight
        scale[self.fractions] = cycle_duration
        return scale

    def unpack(self, w: Array, cycle_duration: float) -> Trajectory:
        """Trajectory in SI units from the scaled decision vector w [nw]."""
        si = np.asarray(w, dtype=float) * self.scale(cycle_duration)
        stride = self.nx + self.nu
        states = np.append(
            si[: self.steps * stride].reshape(self.steps, stride)[:, : self.nx].ravel(), si[self.state(self.steps)]
        ).reshape(self.steps + 1, self.nx)
        controls = si[: self.steps * stride].reshape(self.steps, stride)[:, self.nx :]
        forces, velocities = np.split(controls.reshape(self.steps, 2 * self.legs, self.dimension), 2, axis=1)
        durations = si[self.fractions]
        return Trajectory(
            times=knot_times(durations, self.knots_per_phase),
            base=states[:, : self.nb].copy(),
            feet=states[:, self.nb :].reshape(self.steps + 1, self.legs, self.dimension).copy(),
            forces=forces.copy(),
            foot_velocities=velocities.copy(),
            durations=durations.copy(),
        )

    def pack(self, trajectory: Trajectory, cycle_duration: float) -> Array:
        """The scaled decision vector w [nw] of a trajectory; the inverse of `unpack`."""
        knots, steps = self.steps + 1, self.steps
        states = np.hstack([trajectory.base, trajectory.feet.reshape(knots, -1)])
        controls = np.hstack([trajectory.forces.reshape(steps, -1), trajectory.foot_velocities.reshape(steps, -1)])
        body = np.hstack([states[:-1], controls]).ravel()
        return np.concatenate([body, states[-1], trajectory.durations]) / self.scale(cycle_duration)


def layout_of(scenario: Scenario) -> Layout:
    """The layout of a scenario's problem."""
    robot, transcription = scenario.robot, scenario.transcription
    return Layout(
        dimension=robot.dimension,
        legs=len(robot.legs),
        phases=transcription.phases,
        knots_per_phase=transcription.knots_per_phase,
        weight=robot.mass * GRAVITY,
    )


def knot_times(durations: Array, knots_per_phase: int) -> Array:
    """Times [K+1] of the knots: each phase's duration split into equal steps."""
    steps = np.repeat(np.asarray(durations) / knots_per_phase, knots_per_phase)
    return np.concatenate([[0.0], np.cumsum(steps)])
