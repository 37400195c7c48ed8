"""Where an optimiser starts when nothing is known: an upright glide along the command, or the paper's random start."""

from __future__ import annotations

import hashlib

import numpy as np

from gaitflow.config.robot import Robot
from gaitflow.core import twist
from gaitflow.core.layout import Layout
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory


def nominal(robot: Robot, layout: Layout, task: Task) -> Array:
    """w [nw] of a level base that follows the command over its default feet, each carrying its share of the weight."""
    cycle = task.cycle_duration
    durations = np.full(layout.phases, cycle / layout.phases)
    base, feet = _glide(robot, layout, task, durations)
    forces = np.zeros((layout.steps, layout.legs, layout.dimension))
    forces[..., -1] = layout.weight / layout.legs
    feet[..., -1] = 0.0
    steps = np.diff(layout.times(durations))
    velocities = np.diff(feet, axis=0) / steps[:, None, None]
    motion = Trajectory(layout.times(durations), base, feet, forces, forces, velocities, durations)
    return layout.pack(motion, cycle)


def random(robot: Robot, layout: Layout, task: Task, rng: np.random.Generator) -> Array:
    """w [nw] drawn knot by knot: states and controls uniform in physical ranges, durations uniform and normalised.

    Section IV.B's "randomly initialize the state variables"; the ranges are ours, the paper prints none.
    """
    d, a, knots, steps, cycle = layout.dimension, layout.angles, layout.steps + 1, layout.steps, task.cycle_duration
    box = np.array(robot.box)
    shares = rng.uniform(0.5, 1.5, layout.phases)
    durations = cycle * shares / shares.sum()
    base, feet = _glide(robot, layout, task, durations)
    base[:, :d] += rng.uniform(-box, box, (knots, d))
    base[:, d : d + a] += rng.uniform(-0.3, 0.3, (knots, a)) * robot.max_tilt
    base[:, d + a : 2 * d + a] += rng.uniform(-0.5, 0.5, (knots, d))
    base[:, 2 * d + a :] += rng.uniform(-0.5, 0.5, (knots, a))
    feet = feet + (base[:, None, :d] - _glide(robot, layout, task, durations)[0][:, None, :d])
    feet += rng.uniform(-box, box, (knots, layout.legs, d))
    feet[..., -1] = np.maximum(feet[..., -1], 0.0)
    forces = rng.uniform(-0.3, 0.3, (steps, layout.legs, d)) * layout.weight
    forces[..., -1] = rng.uniform(0.0, 1.0, (steps, layout.legs)) * layout.weight
    fastest = min(2.0 * max(abs(task.speed), 0.5), robot.max_foot_speed)
    velocities = rng.uniform(-1.0, 1.0, (steps, layout.legs, d)) * fastest
    motion = Trajectory(layout.times(durations), base, feet, forces, forces, velocities, durations)
    return layout.pack(motion, cycle)


def seed_of(*parts: object) -> int:
    """A seed that depends on the parts alone, so that a unit solves the same wherever it runs."""
    return int.from_bytes(hashlib.sha256(repr(parts).encode()).digest()[:8], "big")


def _glide(robot: Robot, layout: Layout, task: Task, durations: Array) -> tuple[Array, Array]:
    """Base [K+1, nb] on the commanded path at standing height, and feet [K+1, legs, d] at their default places."""
    d, a = layout.dimension, layout.angles
    times = layout.times(durations)
    default = np.array([leg.default_foot for leg in robot.legs])
    horizontal = [0] if d == 2 else [0, 1]
    turned = twist.headings(task, times)
    base = np.zeros((layout.steps + 1, layout.nb))
    base[:, horizontal] = twist.displacements(task, times)[:, horizontal]
    base[:, d - 1] = -default[:, -1].mean()
    base[:, [d + a + i for i in horizontal]] = twist.velocities(task, times)[:, horizontal]
    places = np.broadcast_to(default, (len(times), *default.shape)).copy()
    if d == 3:
        base[:, d] = turned
        base[:, layout.nb - 1] = task["yaw_rate"]
        c, s = np.cos(turned)[:, None], np.sin(turned)[:, None]
        places[..., 0], places[..., 1] = c * default[:, 0] - s * default[:, 1], s * default[:, 0] + c * default[:, 1]
    return base, base[:, None, :d] + places
