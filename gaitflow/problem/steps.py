"""The terms of one step, as the same function of a few variables for all steps of a motion.

The variables are the states at a step's ends, its forces and foot velocities, and the phase durations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from gaitflow.config.scenario import Scenario
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.problem import friction, kinematics
from gaitflow.problem.dynamics import Node, body_of, node
from gaitflow.problem.objectives import StepCost
from gaitflow.problem.step import base_defects
from gaitflow.problem.task import TaskParameters, task_parameters


@dataclass(frozen=True, eq=False)
class Step:
    """A step between two nodes at times t0 and t1 [s] of the cycle, h = t1 - t0, where forces are linear or held.

    forces: [d] over the robot's weight, at its start; velocities: [d] m/s, of the feet. One a leg.
    """

    start: Node
    end: Node
    times: tuple[ca.SX, ca.SX]
    h: ca.SX
    forces: Sequence[ca.SX]
    velocities: Sequence[ca.SX]

    @property
    def middle(self) -> ca.SX:
        """The time [s] in its middle."""
        return (self.times[0] + self.times[1]) / 2


@dataclass(frozen=True, eq=False)
class StepTerms:
    """The cost of a step, unscaled, and its rows by group (see `GaitProblem`); groups that do not apply are empty."""

    cost: ca.SX
    defects: ca.SX
    offsets: ca.SX
    between: ca.SX
    cones: ca.SX
    speeds: ca.SX

    @property
    def groups(self) -> tuple[ca.SX, ...]:
        """The rows."""
        return self.defects, self.offsets, self.between, self.cones, self.speeds

    @property
    def zeros(self) -> StepTerms:
        """Terms of these sizes that are 0."""
        return StepTerms(ca.SX(0), *(ca.SX.zeros(group.numel()) for group in self.groups))


def step_terms(scenario: Scenario, task: TaskParameters, step: Step) -> StepTerms:
    """The terms of one step."""
    rule, start, end, h = scenario.transcription.integrator, step.start, step.end, step.h
    cost = StepCost(scenario.robot, task, (start, end), step.times, h)
    moved = ca.vertcat(*end.feet) - ca.vertcat(*start.feet)
    at = step.times[0] if scenario.transcription.forces == "linear" else step.middle
    turning = scenario.tasks.varies("yaw_rate")
    speeds = [task.into_frame(velocity, step.middle)[:-1] for velocity in step.velocities if turning]
    return StepTerms(
        cost=cost.sampled(scenario.objective) if rule == "euler" else cost.integrated(scenario.objective),
        defects=ca.vertcat(base_defects(rule, start, end, h), moved - h * ca.vertcat(*step.velocities)),
        offsets=kinematics.foot_offsets(scenario.robot, start.position, start.angles, start.feet),
        between=ca.SX(0, 1) if rule == "euler" else _middle_offsets(scenario, start, end, h),
        cones=friction.friction_rows(task["friction"], [task.into_frame(force, at) for force in step.forces]),
        speeds=ca.vertcat(*speeds) if turning else ca.SX(0, 1),
    )


def one_step(scenario: Scenario, layout: Layout, scale: float) -> tuple[ca.Function, NDArray[np.intp], Array]:
    """`function`, its cost over `scale`, with `places` and `data` of `Copies`."""
    half, phases = layout.legs * layout.dimension, layout.phases
    sizes = [layout.nx, layout.nx, half, half if layout.linear_forces else 0, half, 1, phases - 1]
    x, task = ca.SX.sym("x", sum(sizes)), ca.SX.sym("task", len(AXES))
    data = ca.SX.sym("data", 1 + phases)
    first, last, forces, end_forces, velocities, own, others = ca.vertsplit(x, np.cumsum([0, *sizes]).tolist())
    share, before, earlier = ca.vertsplit(data, [0, 1, 2, 1 + phases])
    parameters = task_parameters(scenario.tasks, task)
    body, cycle = body_of(scenario.robot, parameters), parameters["cycle_duration"]

    def end_of(state: ca.SX, pushes: ca.SX) -> Node:
        feet = ca.vertsplit(state[layout.nb :], layout.dimension)
        return node(body, state[: layout.nb], feet, ca.vertsplit(pushes * layout.weight, layout.dimension))

    h, begin = cycle * own * share, cycle * (ca.dot(earlier, others) + own * before)
    step = Step(
        end_of(first, forces), end_of(last, end_forces if layout.linear_forces else forces), (begin, begin + h), h,
        ca.vertsplit(forces, layout.dimension), ca.vertsplit(velocities, layout.dimension),
    )  # fmt: skip
    terms = step_terms(scenario, parameters, step)
    function = ca.Function("step", [x, data, task], [terms.cost / scale, ca.vertcat(*terms.groups)])
    places = np.array([_places(layout, k) for k in range(layout.steps)], dtype=np.intp)
    return function, places, np.array([_data(layout, k) for k in range(layout.steps)])


def _places(layout: Layout, k: int) -> list[int]:
    phase, legs = layout.phase_of(k), range(layout.legs)
    slices = [layout.state(k), layout.state(k + 1), *(layout.force(k, leg) for leg in legs)]
    if layout.linear_forces:
        slices += [layout.end_force(k, leg) for leg in legs]
    slices += [layout.foot_velocity(k, leg) for leg in legs]
    fractions = range(layout.fractions.start, layout.fractions.stop)
    own_first = [fractions[phase], *(each for other, each in enumerate(fractions) if other != phase)]
    return [*(place for each in slices for place in range(each.start, each.stop)), *own_first]


def _data(layout: Layout, k: int) -> list[float]:
    """The step's share of its phase, those before it in the phase, and which of the other phases are earlier."""
    phase, inner = layout.phase_of(k), k % layout.knots_per_phase
    earlier = [float(other < phase) for other in range(layout.phases) if other != phase]
    return [float(layout.shares[inner]), float(layout.shares[:inner].sum()), *earlier]


def _middle_offsets(scenario: Scenario, start: Node, end: Node, h: ca.SX) -> ca.SX:
    """Foot offsets in the middle of a step, of the cubic through both ends."""
    position = (start.position + end.position) / 2 + h / 8 * (start.velocity - end.velocity)
    angles = (start.angles + end.angles) / 2 + h / 8 * (start.angle_rates - end.angle_rates)
    feet = [(a + b) / 2 for a, b in zip(start.feet, end.feet, strict=True)]
    return kinematics.foot_offsets(scenario.robot, position, angles, feet)
