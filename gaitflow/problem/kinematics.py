"""Eq. (5): each foot stays in a box of half lengths b around its default position in the base frame."""

from __future__ import annotations

import casadi as ca

from gaitflow.config.robot import Robot
from gaitflow.problem.layout import Layout
from gaitflow.problem.orientation import world_to_base


def foot_offsets(robot: Robot, layout: Layout, x: ca.SX) -> ca.SX:
    """R (p_l - r) - default_l [legs*d] m for all feet; eq. (5) asks for -b <= offset <= b."""
    d = layout.dimension
    rotation = world_to_base(x[d : d + layout.angles])
    offsets = []
    for index, leg in enumerate(robot.legs):
        foot = x[layout.nb + index * d : layout.nb + (index + 1) * d]
        offsets.append(rotation @ (foot - x[:d]) - ca.DM(list(leg.default_foot)))
    return ca.vertcat(*offsets)
