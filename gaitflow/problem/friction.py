"""Eq. (6): the friction cone as a pyramid."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca


def friction_rows(friction: ca.SX, forces: Sequence[ca.SX]) -> ca.SX:
    """f_t - mu f_n and -f_t - mu f_n for each leg and tangent, [legs * 2(d-1)]; eq. (6) asks for <= 0.

    Tangents are along and across the commanded direction, so forces [d] are given in the frame that follows the twist:
    then a gait does not depend on where its cycle is cut while it turns.

    The cone is convex: a force that runs linearly between two points of it never leaves it.
    """
    rows = []
    for force in forces:
        normal = force[-1]
        for tangent in ca.vertsplit(force[:-1]):
            rows += [tangent - friction * normal, -tangent - friction * normal]
    return ca.vertcat(*rows)
