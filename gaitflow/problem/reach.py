"""J4: rows that keep the swings that are followed within the legs' reach.

A foot leaves the ground from rest, so at first the body runs ahead of it. A foot lands at rest, so before touchdown it
is ahead of the body. At these times a leg is at its longest, outside the kinematic box. Simulated robots of all gaits
walk while no leg stretches beyond STRETCH, and fall where the curve needs straight knees.
"""

from __future__ import annotations

import casadi as ca

from gaitflow.config.limbs import Limb
from gaitflow.problem.dynamics import Node
from gaitflow.problem.limb import LegPose
from gaitflow.problem.orientation import world_to_base

STRETCH = 0.96  # of thigh and shank together: a knee that is bent by 32 degrees
PARTS = (0.1, 0.15, 0.2)  # of a swing after its start and before its end: where a leg is at its longest


def reach_rows(limb: Limb, node: Node, foot: ca.SX, way: ca.SX, swing: ca.SX, side: ca.SX, apex: float) -> ca.SX:
    """How much longer a leg is than STRETCH allows at PARTS of a swing [parts], over that; asks for <= 0.

    node: where the foot [3] m lifts off (side 1) or touches down (side -1). The body goes on, or came, at its velocity
    there; the foot goes a cycle's way [3] m in `swing` [s], up to `apex` [m] and down.
    """
    into_base = world_to_base(node.angles)
    rows = []
    for part in PARTS:
        moved = side * (way * _minimum_jerk(part) - node.velocity * (part * swing))
        followed = foot + moved + ca.DM([0.0, 0.0, apex * _minimum_jerk(2 * part)])
        rows.append(LegPose(limb, into_base @ (followed - node.position)).length / STRETCH - 1)
    return ca.vertcat(*rows)


def _minimum_jerk(x: float) -> float:
    """The smoothest way from 0 to 1."""
    return x**3 * (10 - 15 * x + 6 * x**2)
