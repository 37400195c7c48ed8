"""Eq. (5): each foot stays in a box of half lengths b around its default position in the base frame."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from gaitflow.config.robot import Robot
from gaitflow.problem.orientation import world_to_base


def foot_offsets(robot: Robot, position: ca.SX, angles: ca.SX, feet: Sequence[ca.SX]) -> ca.SX:
    """R (p_l - r) - default_l [legs*d] m for all feet; eq. (5) asks for -b <= offset <= b."""
    rotation = world_to_base(angles)
    return ca.vertcat(
        *(
            rotation @ (foot - position) - ca.DM(list(leg.default_foot))
            for leg, foot in zip(robot.legs, feet, strict=True)
        )
    )
