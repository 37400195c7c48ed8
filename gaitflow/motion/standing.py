"""A robot that stands: a motion like others, in which nothing moves."""

from __future__ import annotations

import numpy as np

from gaitflow.core.layout import Layout
from gaitflow.core.rigid_body import RigidBody, moment
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion.motion import Motion

AT_REST = {"speed": 0.0, "lateral_speed": 0.0, "yaw_rate": 0.0, "acceleration": 0.0}


def standing(motion: Motion) -> Motion:
    """The robot of a motion at rest on the same ground: level, feet at their default places, the weight shared.

    The centre of mass is above x = y = 0. `period` is that of the motion, and has no meaning. Raises ValueError where
    the ground is too steep or too slippery to stand like that.
    """
    scenario, task = motion.scenario, motion.task.replaced(**AT_REST)
    layout, body = Layout.of(scenario), RigidBody.of(scenario["robot"], task)
    feet = body.default_feet.copy()
    height = -float(feet[:, -1].mean())
    feet[:, -1] = 0.0
    base = np.zeros(layout.nb)
    base[layout.dimension - 1] = height
    forces = _shared_weight(body, task, base[: layout.dimension], feet)
    durations = np.full(layout.phases, task.cycle_duration / layout.phases)
    held = np.broadcast_to(forces, (layout.steps, *forces.shape)).copy()
    trajectory = Trajectory(
        times=layout.times(durations),
        base=np.tile(base, (layout.steps + 1, 1)),
        feet=np.tile(feet, (layout.steps + 1, 1, 1)),
        forces=held,
        end_forces=held.copy(),
        foot_velocities=np.zeros_like(held),
        durations=durations,
    )
    pattern = "/".join(["1" * layout.phases] * layout.legs)
    return Motion.of(scenario, trajectory, task, pattern, motion.swing_apex, motion.point)


def _shared_weight(body: RigidBody, task: Task, position: Array, feet: Array) -> Array:
    """The least forces [legs, d] N that carry the weight without a moment about the body at `position` [d] m."""
    legs, d = feet.shape
    wanted = np.concatenate([-body.mass * body.gravity, np.zeros(body.angles)])
    unit = np.eye(legs * d).reshape(-1, legs, d)
    effects = np.concatenate([unit.sum(axis=1), moment(feet - position, unit).sum(axis=1)], axis=1).T
    forces: Array = np.linalg.lstsq(effects, wanted, rcond=None)[0].reshape(legs, d)
    if (np.abs(forces[:, :-1]) > task["friction"] * forces[:, -1:]).any():
        raise ValueError(
            f"slope = {task['slope']:g}, friction = {task['friction']:g}: the robot cannot stand there level, with its "
            "feet at their default places"
        )
    return forces
