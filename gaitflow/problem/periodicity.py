"""Eq. (3): the periodic task; after one cycle everything repeats, displaced by v T along the terrain."""

from __future__ import annotations

import casadi as ca

from gaitflow.problem.layout import Layout


def periodicity_rows(layout: Layout, first: ca.SX, last: ca.SX, speed: ca.SX, cycle_duration: ca.SX) -> ca.SX:
    """x_K - x_0 - displacement [nx]; eq. (3) asks for 0.

    Base position and feet advance by v T; angles, velocities and heights repeat. The paper prints position, angles and
    feet; velocities repeat too, for a cycle that can be walked again.
    """
    travel = speed * cycle_duration
    shift = [ca.SX(0)] * layout.nx
    shift[0] = travel
    for leg in range(layout.legs):
        shift[layout.nb + leg * layout.dimension] = travel
    return last - first - ca.vertcat(*shift)
