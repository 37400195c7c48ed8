"""Where an optimiser starts when nothing is known: an upright glide at speed v, or the paper's random start."""

from __future__ import annotations

import numpy as np

from gaitflow.config.robot import Robot
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem.layout import Layout, knot_times


def nominal(robot: Robot, layout: Layout, speed: float, cycle_duration: float) -> Array:
    """w [nw] of a level base gliding at v [m/s] over its default feet, each carrying its share of the weight."""
    d, steps = layout.dimension, layout.steps
    durations = np.full(layout.phases, cycle_duration / layout.phases)
    times = knot_times(durations, layout.knots_per_phase)
    default = np.array([leg.default_foot for leg in robot.legs])
    base = np.zeros((steps + 1, layout.nb))
    base[:, 0] = speed * times
    base[:, d - 1] = -default[:, -1].mean()
    base[:, d + layout.angles] = speed
    feet = base[:, None, :d] + default
    feet[..., -1] = 0.0
    forces = np.zeros((steps, layout.legs, d))
    forces[..., -1] = layout.weight / layout.legs
    velocities = np.zeros((steps, layout.legs, d))
    velocities[..., 0] = speed
    return layout.pack(Trajectory(times, base, feet, forces, velocities, durations), cycle_duration)


def random(robot: Robot, layout: Layout, speed: float, cycle_duration: float, rng: np.random.Generator) -> Array:
    """w [nw] drawn knot by knot: states and controls uniform in physical ranges, durations uniform and normalised.

    Section IV.B's "randomly initialize the state variables"; the ranges are ours, the paper prints none.
    """
    d, a, knots, steps = layout.dimension, layout.angles, layout.steps + 1, layout.steps
    default = np.array([leg.default_foot for leg in robot.legs])
    box = np.array(robot.box)
    shares = rng.uniform(0.5, 1.5, layout.phases)
    durations = cycle_duration * shares / shares.sum()
    times = knot_times(durations, layout.knots_per_phase)
    base = np.zeros((knots, layout.nb))
    base[:, :d] = rng.uniform(-box, box, (knots, d))
    base[:, 0] += speed * times
    base[:, d - 1] -= default[:, -1].mean()
    base[:, d : d + a] = rng.uniform(-0.3, 0.3, (knots, a)) * robot.max_tilt
    base[:, d + a : 2 * d + a] = rng.uniform(-0.5, 0.5, (knots, d))
    base[:, d + a] += speed
    base[:, 2 * d + a :] = rng.uniform(-0.5, 0.5, (knots, a))
    feet = base[:, None, :d] + default + rng.uniform(-box, box, (knots, layout.legs, d))
    feet[..., -1] = np.maximum(feet[..., -1], 0.0)
    forces = rng.uniform(-0.3, 0.3, (steps, layout.legs, d)) * layout.weight
    forces[..., -1] = rng.uniform(0.0, 1.0, (steps, layout.legs)) * layout.weight
    velocities = rng.uniform(-1.0, 1.0, (steps, layout.legs, d)) * min(2.0 * max(speed, 0.5), robot.max_foot_speed)
    return layout.pack(Trajectory(times, base, feet, forces, velocities, durations), cycle_duration)
