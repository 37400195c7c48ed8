"""How fast contact forces change. Here forces may jump between phases, but no motor's torque can."""

from __future__ import annotations

import casadi as ca

from gaitflow.core.force_rate import EDGE
from gaitflow.core.layout import Layout
from gaitflow.problem.task import TaskParameters


def force_rate(layout: Layout, w: ca.SX, task: TaskParameters, times: list[ca.SX]) -> ca.SX:
    """Integral of the squared rates of all contact forces [N^2/s] of a decision vector with knots at times [s].

    Within a phase forces are linear in time. Between two phases, and from a cycle's end to the next one's start, a jump
    counts as a ramp of EDGE seconds.
    """
    total = ca.SX(0)
    for leg in range(layout.legs):
        for step in range(layout.steps):
            first, last = w[layout.force(step, leg)], w[layout.end_force(step, leg)]
            total += ca.sumsqr(last - first) / (times[step + 1] - times[step])
            if step + 1 == layout.steps:
                total += ca.sumsqr(task.out_of_frame(w[layout.force(0, leg)], task["cycle_duration"]) - last) / EDGE
            elif (step + 1) % layout.knots_per_phase == 0:
                total += ca.sumsqr(w[layout.force(step + 1, leg)] - last) / EDGE
    return total * layout.weight**2
