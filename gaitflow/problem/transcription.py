"""Eq. (2): assembles the terms into one nonlinear program on the knots (section III.B, end).

Two forms share the terms: `nlp`, where a pattern enters through bounds, and `minlp`, where contact variables enter
through big-M rows. Both are in scaled variables (see `layout`); a stored cost is the program's cost times `cost_scale`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.trajectory import Array
from gaitflow.problem import contact, dynamics, friction, integrator, kinematics, objectives, periodicity, timing
from gaitflow.problem.layout import Layout, layout_of


@dataclass(frozen=True)
class Bounds:
    """Bounds of a program: variables [nw] and rows [ng]."""

    lower: Array
    upper: Array
    lower_rows: Array
    upper_rows: Array


@dataclass(frozen=True)
class GaitProblem:
    """A scenario's program; build it with `transcribe`.

    nlp: (w [nw], task [2] = (v, T)) -> (cost [1], rows [ng]).
    minlp: (w [nw + legs*phases], task [2]) -> (cost [1], rows [ng_minlp]); the contacts follow w, leg-major.
    Rows come in groups: defects [K, nx], foot offsets [K, legs*d], friction [K, legs*2(d-1)], periodicity [nx],
    cycle [1]; the minlp has big-M rows [K, legs*(2d+2)] and, with one stance per leg, stance rows after them.
    """

    scenario: Scenario
    layout: Layout
    nlp: ca.Function
    cost_scale: float

    @property
    def ng(self) -> int:
        """Number of rows of `nlp`."""
        return int(self.nlp.numel_out(1))

    @cached_property
    def _free(self) -> Bounds:
        """Bounds before any pattern is imposed."""
        return _physical_bounds(self.scenario, self.layout)

    def bounds(self, pattern: Pattern) -> Bounds:
        """Bounds of `nlp` that impose a pattern. Raises ValueError when its shape is not the scenario's.

        Rows whose every variable the pattern fixes are left free: a constant row has no gradient and only makes the
        solver's matrix singular.
        """
        layout = self.layout
        if (pattern.legs, pattern.phases) != (layout.legs, layout.phases):
            raise ValueError(
                f"pattern {pattern.text} has {pattern.legs} legs and {pattern.phases} phases; "
                f"the scenario has {layout.legs} and {layout.phases}"
            )
        lower, upper = self._free.lower.copy(), self._free.upper.copy()
        contact.fix_contacts(layout, pattern, lower, upper)
        lower_rows, upper_rows = self._free.lower_rows.copy(), self._free.upper_rows.copy()
        constant = _constant_rows(layout, pattern)
        lower_rows[constant], upper_rows[constant] = -np.inf, np.inf
        return Bounds(lower, upper, lower_rows, upper_rows)

    @cached_property
    def minlp(self) -> ca.Function:
        """The big-M form, eq. (7) with the pattern as variables."""
        return _minlp(self.scenario, self.layout, self.cost_scale)

    def minlp_bounds(self, pattern: Pattern | None = None) -> Bounds:
        """Bounds of `minlp`; with a pattern its contact variables are fixed: the paper's fixed-gait form."""
        layout = self.layout
        contacts = np.zeros(layout.legs * layout.phases), np.ones(layout.legs * layout.phases)
        if pattern is not None:
            fixed = np.array([float(digit) for row in pattern.rows for digit in row])
            contacts = fixed, fixed
        big_m = layout.steps * layout.legs * (2 * layout.dimension + 2)
        lower_rows = [self._free.lower_rows, np.full(big_m, -np.inf)]
        upper_rows = [self._free.upper_rows, np.zeros(big_m)]
        if self.scenario.stances_per_leg == 1:
            _, least, most = contact.one_stance_rows(layout.legs, layout.phases)
            lower_rows.append(least)
            upper_rows.append(most)
        return Bounds(
            np.concatenate([self._free.lower, contacts[0]]),
            np.concatenate([self._free.upper, contacts[1]]),
            np.concatenate(lower_rows),
            np.concatenate(upper_rows),
        )


def transcribe(scenario: Scenario) -> GaitProblem:
    """Build the program of a scenario."""
    layout = layout_of(scenario)
    scale = _cost_scale(scenario, layout)
    w, parameters = ca.SX.sym("w", layout.nw), ca.SX.sym("task", 2)
    cost, groups = _terms(scenario, layout, w, parameters)
    nlp = ca.Function("nlp", [w, parameters], [cost / scale, ca.vertcat(*groups)], ["w", "task"], ["cost", "rows"])
    return GaitProblem(scenario, layout, nlp, scale)


def _cost_scale(scenario: Scenario, layout: Layout) -> float:
    """A cost of order one for the solver: the largest weight, forces over the robot's weight."""
    weights = scenario.objective.as_data()
    force = weights.pop("force") * layout.weight**2
    return max(force, *weights.values())


def _terms(scenario: Scenario, layout: Layout, w: ca.SX, parameters: ca.SX) -> tuple[ca.SX, list[ca.SX]]:
    """Cost and the row groups that both forms share."""
    robot = scenario.robot
    speed, cycle = parameters[0], parameters[1]
    x, u, h = ca.SX.sym("x", layout.nx), ca.SX.sym("u", layout.nu), ca.SX.sym("h")
    to_si = ca.DM(layout.scale(1.0)[layout.control(0)])

    def rate(state: ca.SX) -> ca.SX:
        return dynamics.state_rate(robot, scenario.terrain.slope_deg, layout, state, u * to_si)

    step = ca.Function("step", [x, u, h], [integrator.step(scenario.transcription.integrator, rate, x, h)])
    running = ca.Function(
        "running", [x, u, speed], [objectives.integrand(scenario.objective, robot, layout, x, u * to_si, speed)]
    )
    box = ca.Function("box", [x], [kinematics.foot_offsets(robot, layout, x)])
    pyramid = ca.Function("pyramid", [u], [friction.friction_rows(layout, scenario.terrain.friction, u)])

    fractions = w[layout.fractions]
    cost, defects, offsets, cones = ca.SX(0), [], [], []
    for k in range(layout.steps):
        state, control = w[layout.state(k)], w[layout.control(k)]
        duration = cycle * fractions[layout.phase_of(k)] / layout.knots_per_phase
        cost += duration * running(state, control, speed)
        defects.append(w[layout.state(k + 1)] - step(state, control, duration))
        offsets.append(box(state))
        cones.append(pyramid(control))
    closing = periodicity.periodicity_rows(layout, w[layout.state(0)], w[layout.state(layout.steps)], speed, cycle)
    return cost, [*defects, *offsets, *cones, closing, timing.cycle_row(fractions)]


def _minlp(scenario: Scenario, layout: Layout, cost_scale: float) -> ca.Function:
    contacts = layout.legs * layout.phases
    w, parameters = ca.SX.sym("w", layout.nw + contacts), ca.SX.sym("task", 2)
    cost, groups = _terms(scenario, layout, w[: layout.nw], parameters)
    c = ca.reshape(w[layout.nw :], layout.phases, layout.legs)
    groups += [
        contact.big_m_rows(scenario.robot, layout, w[layout.state(k)], w[layout.control(k)], c[layout.phase_of(k), :].T)
        for k in range(layout.steps)
    ]
    if scenario.stances_per_leg == 1:
        rows, _, _ = contact.one_stance_rows(layout.legs, layout.phases)
        groups.append(ca.DM(rows) @ w[layout.nw :])
    return ca.Function(
        "minlp", [w, parameters], [cost / cost_scale, ca.vertcat(*groups)], ["w", "task"], ["cost", "rows"]
    )


def _physical_bounds(scenario: Scenario, layout: Layout) -> Bounds:
    """Limits of the robot and the shared rows: equalities, boxes and friction."""
    robot, d, a = scenario.robot, layout.dimension, layout.angles
    lower, upper = np.full(layout.nw, -np.inf), np.full(layout.nw, np.inf)
    lift, force = contact.highest_lift(robot), robot.max_force / layout.weight
    for knot in range(layout.steps + 1):
        angles = layout.state(knot).start + d
        lower[angles : angles + a], upper[angles : angles + a] = -robot.max_tilt, robot.max_tilt
        for leg in range(layout.legs):
            height = layout.foot(knot, leg).stop - 1
            lower[height], upper[height] = 0.0, lift  # eq. (7b)
    for step in range(layout.steps):
        for leg in range(layout.legs):
            normal = layout.force(step, leg).stop - 1
            lower[normal], upper[normal] = 0.0, force  # eq. (7a)
            velocity = layout.foot_velocity(step, leg)
            lower[velocity], upper[velocity] = -robot.max_foot_speed, robot.max_foot_speed
    shortest, longest = timing.fraction_bounds(layout.phases, scenario.transcription.min_phase_fraction)
    lower[layout.fractions], upper[layout.fractions] = shortest, longest
    # Where the cycle starts along the path changes nothing; sideways only the lateral term says where the path is.
    fixed = 1 if d == 2 or scenario.objective.lateral_foot else 2
    start = layout.state(0).start
    lower[start : start + fixed] = upper[start : start + fixed] = 0.0

    box = np.tile(robot.box, layout.steps * layout.legs)
    cones = layout.steps * layout.legs * 2 * (d - 1)
    defects, closing = np.zeros(layout.steps * layout.nx), np.zeros(layout.nx + 1)
    return Bounds(
        lower,
        upper,
        np.concatenate([defects, -box, np.full(cones, -np.inf), closing]),
        np.concatenate([defects, box, np.zeros(cones), closing]),
    )


def _constant_rows(layout: Layout, pattern: Pattern) -> Array:
    """Mask [ng] of the rows that a pattern makes constant: foot height in stance, friction in swing."""
    d, steps = layout.dimension, layout.steps
    columns = np.array([pattern.column(layout.phase_of(k)) for k in range(steps)], dtype=bool)
    defects = np.zeros((steps, layout.nx), dtype=bool)
    heights = layout.nb + d * np.arange(layout.legs) + d - 1
    defects[:, heights] = columns
    offsets = np.zeros(steps * layout.legs * d, dtype=bool)
    cones = np.repeat(~columns, 2 * (d - 1), axis=1)
    closing = np.zeros(layout.nx + 1, dtype=bool)
    closing[heights] = columns[0] & columns[-1]
    return np.concatenate([defects.ravel(), offsets, cones.ravel(), closing])
