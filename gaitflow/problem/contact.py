"""Eq. (7): unilateral forces, no penetration, no force in swing, no slip and no lift in stance.

A pattern enters in one of two ways. *Bounds*: variables that the pattern decides are fixed (lower = upper) and the
solver drops them. *Big-M*: rows switch the conditions by a contact variable c in {0, 1}; this is the paper's form,
needed where the pattern itself is a decision.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import casadi as ca
import numpy as np

from gaitflow.config.robot import Robot
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.trajectory import Array


def highest_lift(robot: Robot) -> float:
    """Largest foot height over the ground [m]: the longest leg of the box; also the big-M of eq. (7d)."""
    return max(-leg.default_foot[-1] for leg in robot.legs) + robot.box[-1]


def fix_contacts(layout: Layout, pattern: Pattern, lower: Array, upper: Array, clearance: float = 0.0) -> None:
    """Impose a pattern on the variable bounds [nw] in place, eq. (7c, 7d).

    Swing: force = 0, and in its middle the foot is at least `clearance` [m] above the ground. Stance: foot
    velocity = 0, and foot height = 0 at every knot of the phase, its end included.
    """
    for leg in range(layout.legs if clearance else 0):
        for knot in middles_of_swings(pattern.rows[leg], layout.knots_per_phase):
            height = layout.foot(knot, leg).stop - 1
            lower[height] = clearance
    for leg in range(layout.legs if layout.energy else 0):
        stands = [float(digit) for digit in pattern.rows[leg]]
        lower[layout.contacts(leg)] = upper[layout.contacts(leg)] = stands
    for step in range(layout.steps):
        column = pattern.column(layout.phase_of(step))
        for leg in range(layout.legs):
            if not column[leg]:
                for force in (layout.force(step, leg), layout.end_force(step, leg)):
                    lower[force] = upper[force] = 0.0
            else:
                velocity = layout.foot_velocity(step, leg)
                lower[velocity] = upper[velocity] = 0.0
                # The first and the last knot are one place of the cycle. Left to the closing row alone, a height that
                # is 0 would have no room above its bound, and no interior-point method likes that.
                closed = {step, step + 1} | ({layout.steps} if step == 0 else set())
                closed |= {0} if step + 1 == layout.steps else set()
                for knot in closed:
                    height = layout.foot(knot, leg).stop - 1
                    lower[height] = upper[height] = 0.0


def middles_of_swings(row: str, knots_per_phase: int) -> list[int]:
    """The knots in the middle of each swing of a leg's row "0110", knot 0 as well where the last one is it."""
    phases = len(row)
    steps, found = phases * knots_per_phase, set()
    for phase in range(phases):
        if row[phase] == "0" and row[phase - 1] == "1":
            length = next(n for n in range(1, phases) if row[(phase + n) % phases] == "1") * knots_per_phase
            for half in (length // 2, (length + 1) // 2):
                middle = phase * knots_per_phase + half
                found |= {middle % steps} | ({middle} if middle == steps else set())
    return sorted(found)


def big_m_rows(robot: Robot, layout: Layout, x: ca.SX, u: ca.SX, contact: ca.SX) -> ca.SX:
    """Big-M form of eq. (7c, 7d) for one step, [legs*(2d+2)]; all ask for <= 0. contact [legs]; forces over m g.

    Tangential forces need no row: friction, eq. (6), bounds them by the normal force.
    """
    d = layout.dimension
    force_limit, lift = robot.max_force / layout.weight, highest_lift(robot)
    rows = []
    for leg in range(layout.legs):
        c = contact[leg]
        normal = u[leg * d + d - 1]
        height = x[layout.nb + leg * d + d - 1]
        velocity = u[(layout.legs + leg) * d : (layout.legs + leg + 1) * d]
        slack = (1 - c) * robot.max_foot_speed
        rows += [normal - c * force_limit, height - (1 - c) * lift, velocity - slack, -velocity - slack]
    return ca.vertcat(*rows)


def end_force_rows(robot: Robot, layout: Layout, forces: Sequence[ca.SX], contact: ca.SX) -> ca.SX:
    """Big-M form of eq. (7c) for the forces [d] each at the end of a phase, over m g; [legs], all ask for <= 0."""
    limit = robot.max_force / layout.weight
    return ca.vertcat(*(force[-1] - contact[leg] * limit for leg, force in enumerate(forces)))


def one_stance_rows(legs: int, phases: int) -> tuple[Array, Array, Array]:
    """Linear rows A c in [lower, upper] that admit exactly the patterns with one touchdown per leg and cycle.

    c [legs*phases] leg-major. A leg's cyclic row has at most one run of contacts iff no four phases i<j<k<l read
    1,0,1,0 or 0,1,0,1: |c_i - c_j + c_k - c_l| <= 1. At least one and at most phases-1 contacts make it exactly one.
    """
    rows, lower, upper = [], [], []
    for leg in range(legs):
        count = np.zeros(legs * phases)
        count[leg * phases : (leg + 1) * phases] = 1
        rows.append(count)
        lower.append(1.0)
        upper.append(phases - 1.0)
        for chosen in combinations(range(phases), 4):
            row = np.zeros(legs * phases)
            row[[leg * phases + i for i in chosen]] = (1, -1, 1, -1)
            rows.append(row)
            lower.append(-1.0)
            upper.append(1.0)
    return np.array(rows), np.array(lower), np.array(upper)
