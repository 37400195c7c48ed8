"""How the scaled decision vector of an artifact unfolds into a trajectory in SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.core.trajectory import Array, Trajectory


@dataclass(frozen=True)
class Layout:
    """Sizes of the decision vector w = (x_0, u_0, x_1, ..., x_K, durations), knot by knot.

    x = (base, feet legs*dimension), u = (forces legs*dimension, foot velocities legs*dimension), legs in the order of
    `legs`, coordinates fastest; K = phases * knots_per_phase. The phase durations come last, as fractions of the cycle
    duration. `rows` is the number of constraint rows of the problem.
    """

    phases: int
    knots_per_phase: int
    legs: tuple[str, ...]
    dimension: int
    base: int
    rows: int

    @property
    def steps(self) -> int:
        """Number of steps K."""
        return self.phases * self.knots_per_phase

    @property
    def duration_slice(self) -> tuple[int, int]:
        """First and end index of the durations in w."""
        return self.variables - self.phases, self.variables

    @property
    def variables(self) -> int:
        """Size nw of w."""
        feet = len(self.legs) * self.dimension
        return (self.steps + 1) * (self.base + feet) + self.steps * 2 * feet + self.phases


def unpack(layout: Layout, scale: Array, w: Array, cycle_duration: float) -> Trajectory:
    """The trajectory in a decision vector w [nw]; w * scale is in SI units but for durations, fractions of T [s]."""
    si = w * scale
    steps, legs, d = layout.steps, len(layout.legs), layout.dimension
    states = layout.base + legs * d
    body, durations = si[: -layout.phases], si[-layout.phases :] * cycle_duration
    # A last control of nothing makes the knots rows of one matrix.
    knots = np.append(body, np.zeros(2 * legs * d)).reshape(steps + 1, states + 2 * legs * d)
    controls = knots[:-1, states:].reshape(steps, 2, legs, d)
    step_lengths = np.repeat(durations / layout.knots_per_phase, layout.knots_per_phase)
    return Trajectory(
        times=np.concatenate([[0.0], np.cumsum(step_lengths)]),
        base=knots[:, : layout.base].copy(),
        feet=knots[:, layout.base : states].reshape(steps + 1, legs, d).copy(),
        forces=controls[:, 0].copy(),
        foot_velocities=controls[:, 1].copy(),
        durations=durations,
    )
