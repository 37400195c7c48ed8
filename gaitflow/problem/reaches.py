"""How far each leg reaches at the ends of phases, as the same function of a few variables for all phases of a leg."""

from __future__ import annotations

import casadi as ca
import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.problem.copies import Copies
from gaitflow.problem.dynamics import Node, body_of, node
from gaitflow.problem.reach import PARTS, reach_rows
from gaitflow.problem.task import TaskParameters, task_parameters


def leg_reach(
    scenario: Scenario, task: TaskParameters, leg: int, end: Node, foot: ca.SX, time: ca.SX, phases: ca.SX, side: ca.SX
) -> ca.SX:
    """Rows [parts] of a leg whose foot [3] m is where a phase ends at a time [s]; see `reach_rows`.

    phases: their fractions of the cycle, then in which of them the leg stands. side: 1 where it lifts off, -1 where it
    touches down, 0 where its contact stays.
    """
    fractions, contacts = ca.vertsplit(phases, phases.numel() // 2)
    swing = task["cycle_duration"] * ca.dot(fractions, 1 - contacts)
    way = task.out_of_frame(task.passing(scenario.robot.legs[leg].default_foot), time) * task["cycle_duration"]
    limbs = scenario.robot.limbs or ()
    return reach_rows(limbs[leg], end, foot, way, swing, side, scenario.swing_clearance)


def reach_copies(scenario: Scenario, layout: Layout, first: int) -> tuple[Copies, ...]:
    """The rows of all legs, a family a leg and a copy a phase, in the problem from row `first` on."""
    phases, parts, families = layout.phases, len(PARTS), []
    earlier = np.tril(np.ones((phases, phases)))
    for leg in range(layout.legs):
        x, task = ca.SX.sym("x", layout.nb + layout.dimension + 2 * phases), ca.SX.sym("task", len(AXES))
        data = ca.SX.sym("data", 3 * phases)  # which phase it is, which is next, which have ended
        base, foot, around = ca.vertsplit(x, [0, layout.nb, layout.nb + layout.dimension, x.numel()])
        here, following, ended = ca.vertsplit(data, phases)
        parameters = task_parameters(scenario.tasks, task)
        end = node(body_of(scenario.robot, parameters), base, [foot], [ca.SX.zeros(layout.dimension)])
        time = parameters["cycle_duration"] * ca.dot(ended, around[:phases])
        side = ca.dot(here - following, around[phases:])
        rows = leg_reach(scenario, parameters, leg, end, foot, time, around, side)
        knots = [(phase + 1) * layout.knots_per_phase for phase in range(phases)]
        cycle = [*_range(layout.fractions), *_range(layout.contacts(leg))]
        places = [[*_range(layout.state(k))[: layout.nb], *_range(layout.foot(k, leg)), *cycle] for k in knots]
        families.append(
            Copies(
                ca.Function("reach", [x, data, task], [ca.SX(0), rows]),
                np.array(places, dtype=np.intp),
                np.hstack([np.eye(phases), np.roll(np.eye(phases), 1, axis=1), earlier]),
                first + parts * (leg * phases + np.arange(phases)[:, None]) + np.arange(parts),
            )
        )
    return tuple(families)


def _range(places: slice) -> range:
    return range(places.start, places.stop)
