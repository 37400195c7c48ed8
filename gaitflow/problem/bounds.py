"""Limits of the robot and the task as bounds on a program's variables and rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.trajectory import Array
from gaitflow.problem import contact, timing
from gaitflow.problem.reach import PARTS


@dataclass(frozen=True)
class Bounds:
    """Bounds of a program: variables [nw] and rows [ng]."""

    lower: Array
    upper: Array
    lower_rows: Array
    upper_rows: Array


def physical_bounds(scenario: Scenario, layout: Layout) -> Bounds:
    """Limits of the robot and the shared rows: equalities, boxes and friction."""
    robot, d, a = scenario.robot, layout.dimension, layout.angles
    lower, upper = np.full(layout.nw, -np.inf), np.full(layout.nw, np.inf)
    lift, force = contact.highest_lift(robot), robot.max_force / layout.weight
    turning = scenario.tasks.varies("yaw_rate")
    for knot in range(layout.steps + 1):
        # A body that turns has no limit on its yaw, which is measured from where the cycle began.
        angles = slice(layout.state(knot).start + d + (1 if turning else 0), layout.state(knot).start + d + a)
        lower[angles], upper[angles] = -robot.max_tilt, robot.max_tilt
        for leg in range(layout.legs):
            height = layout.foot(knot, leg).stop - 1
            lower[height], upper[height] = 0.0, lift  # eq. (7b)
    for step in range(layout.steps):
        for leg in range(layout.legs):
            for node_force in (layout.force(step, leg), layout.end_force(step, leg)):
                normal = node_force.stop - 1
                lower[normal], upper[normal] = 0.0, force  # eq. (7a)
            velocity = layout.foot_velocity(step, leg)
            # Where the command turns, rows limit the other two, along the axes of the frame that follows it.
            limited = slice(velocity.stop - 1, velocity.stop) if turning else velocity
            lower[limited], upper[limited] = -robot.max_foot_speed, robot.max_foot_speed
    shortest, longest = timing.fraction_bounds(layout.phases, scenario.transcription.min_phase_fraction)
    lower[layout.fractions], upper[layout.fractions] = shortest, longest
    lower[layout.fractions.stop :], upper[layout.fractions.stop :] = 0.0, 1.0
    # Where the cycle starts along a straight path changes nothing; sideways, the lateral term says where the path is.
    # On the circle of a turn velocity and yaw are measured against the commanded frame, so the cost says both.
    fixed = 0 if turning else 1 if d == 2 or scenario.objective.lateral_foot else 2
    start = layout.state(0).start
    lower[start : start + fixed] = upper[start : start + fixed] = 0.0

    looks = layout.steps if scenario.transcription.integrator == "euler" else 2 * layout.steps
    box = np.tile(robot.box, looks * layout.legs)
    cones = _force_nodes(layout) * layout.legs * 2 * (d - 1)
    speeds = np.full(layout.steps * layout.legs * 2 if turning else 0, robot.max_foot_speed)
    reaches = _reach_rows(scenario, layout)
    defects, closing = np.zeros(layout.steps * layout.nx), np.zeros(layout.nx + 1)
    return Bounds(
        lower,
        upper,
        np.concatenate([defects, -box, np.full(cones, -np.inf), -speeds, np.full(reaches, -np.inf), closing]),
        np.concatenate([defects, box, np.zeros(cones), speeds, np.zeros(reaches), closing]),
    )


def _force_nodes(layout: Layout) -> int:
    """How many times in a cycle there are forces: a step's start each, and the end of a phase where they are linear."""
    return layout.steps + (layout.phases if layout.linear_forces else 0)


def _reach_rows(scenario: Scenario, layout: Layout) -> int:
    """How many rows limit the legs' reach in swings."""
    return layout.legs * layout.phases * len(PARTS) if scenario.follows_swings else 0


def constant_rows(scenario: Scenario, layout: Layout, pattern: Pattern, rows: int) -> Array:
    """Mask [ng] of the rows that say nothing of a pattern.

    Constant ones, as foot height and speed in stance and friction in swing, and reach where no swing begins or ends.
    """
    d, steps, turning = layout.dimension, layout.steps, scenario.tasks.varies("yaw_rate")
    columns = np.array([pattern.column(layout.phase_of(k)) for k in range(steps)], dtype=bool)
    defects = np.zeros((steps, layout.nx), dtype=bool)
    heights = layout.nb + d * np.arange(layout.legs) + d - 1
    defects[:, heights] = columns
    nodes = columns
    if layout.linear_forces:  # a phase has one more of them than steps
        per_phase = columns.reshape(layout.phases, layout.knots_per_phase, layout.legs)
        nodes = np.concatenate([per_phase, per_phase[:, -1:]], axis=1).reshape(-1, layout.legs)
    cones = np.repeat(~nodes, 2 * (d - 1), axis=1)
    speeds = np.repeat(columns, 2, axis=1) if turning else np.zeros(0, dtype=bool)
    closing = np.zeros(layout.nx + 1, dtype=bool)
    closing[heights] = columns[0] | columns[-1]
    reaches = np.zeros(0, dtype=bool)
    if scenario.follows_swings:
        stands = np.array([[digit == "1" for digit in row] for row in pattern.rows])
        reaches = np.repeat(stands == np.roll(stands, -1, axis=1), len(PARTS))
    after = [cones.ravel(), speeds.ravel(), reaches, closing]
    offsets = np.zeros(rows - defects.size - sum(map(len, after)), dtype=bool)
    return np.concatenate([defects.ravel(), offsets, *after])
