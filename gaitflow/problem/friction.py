"""Eq. (6): the friction cone as a pyramid."""

from __future__ import annotations

import casadi as ca

from gaitflow.problem.layout import Layout


def friction_rows(layout: Layout, friction: float, u: ca.SX) -> ca.SX:
    """f_t - mu f_n and -f_t - mu f_n for each leg and tangent, [legs * 2(d-1)]; eq. (6) asks for <= 0."""
    d = layout.dimension
    rows = []
    for leg in range(layout.legs):
        force = u[leg * d : (leg + 1) * d]
        normal = force[d - 1]
        for tangent in range(d - 1):
            rows += [force[tangent] - friction * normal, -force[tangent] - friction * normal]
    return ca.vertcat(*rows)
