"""Eq. (3): the periodic task; after one cycle everything repeats, moved by the commanded twist."""

from __future__ import annotations

import casadi as ca

from gaitflow.core.layout import Layout
from gaitflow.problem.task import TaskParameters


def periodicity_rows(layout: Layout, first: ca.SX, last: ca.SX, task: TaskParameters) -> ca.SX:
    """x_K minus the moved x_0 [nx]; eq. (3) asks for 0.

    Base and feet are turned and displaced by the twist's exponential; velocities are turned and, along the heading,
    raised by acceleration times T. The paper prints position, angles and feet; velocities repeat too, for a cycle that
    can be walked again. Angular velocity is in the base frame and repeats as it is.
    """
    d, a, cycle = layout.dimension, layout.angles, task["cycle_duration"]
    x, y = task.displacement(cycle)
    shift = ca.vertcat(x, 0) if d == 2 else ca.vertcat(x, y, 0)
    turned = ca.vertcat(*[task.heading(cycle) if i == 0 and a == 3 else 0 for i in range(a)])
    gain = ca.vertcat(task["acceleration"] * cycle, ca.SX.zeros(d - 1))

    def moved(point: ca.SX) -> ca.SX:
        return task.out_of_frame(point, cycle) + shift

    expected = [
        moved(first[:d]),
        first[d : d + a] + turned,
        task.out_of_frame(first[d + a : 2 * d + a] + gain, cycle),
        first[2 * d + a : layout.nb],
        *(moved(first[at : at + d]) for at in range(layout.nb, layout.nx, d)),
    ]
    return last - ca.vertcat(*expected)
