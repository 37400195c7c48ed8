"""Eq. (2): assembles the terms into one nonlinear program on the knots (section III.B, end).

Two forms share the terms: `nlp`, where a pattern enters through bounds, and `minlp`, where contact variables enter
through big-M rows. Both are in scaled variables (see `layout`); a stored cost is the program's cost times `cost_scale`.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.problem import contact, friction, periodicity, timing
from gaitflow.problem.bounds import Bounds, constant_rows, physical_bounds
from gaitflow.problem.copies import Copies, Pieces
from gaitflow.problem.dynamics import Body, Node, body_of, node
from gaitflow.problem.energy_elements import energy_elements
from gaitflow.problem.force_rate import force_rate
from gaitflow.problem.reaches import leg_reach, reach_copies
from gaitflow.problem.separable import Element, SeparableProblem
from gaitflow.problem.steps import Step, StepTerms, one_step, step_terms
from gaitflow.problem.task import TaskParameters, task_parameters

KEPT = 8  # programs that a process keeps: those of one scenario's meshes, and of another


@dataclass(frozen=True)
class GaitProblem:
    """A scenario's program; build it with `transcribe`.

    nlp: (w [nw], task [axes]) -> (cost [1], rows [ng]); the task's values are in the order and units of AXES.
    `separable` is the same in parts.
    minlp: (w [nw + legs*phases], task [axes]) -> (cost [1], rows [ng_minlp]); the contacts follow w, leg-major.
    Rows come in groups: defects [K, nx], foot offsets at knots [K, legs*d] and, but for euler, in the middle of steps
    [K, legs*d], friction [force nodes, legs*2(d-1)], where the command may turn horizontal foot velocities
    [K, legs*2], where energy has a swing clearance the legs' reach [legs, phases, parts], periodicity [nx], cycle [1];
    the minlp has big-M rows [K, legs*(2d+2)], those of end forces
    [phases, legs], and, with one stance per leg, stance rows after them.
    """

    scenario: Scenario
    layout: Layout
    separable: SeparableProblem
    cost_scale: float

    @property
    def nlp(self) -> ca.Function:
        """The program as one function."""
        return self.separable.function

    @property
    def ng(self) -> int:
        """Number of rows of `nlp`."""
        return int(self.nlp.numel_out(1))

    @cached_property
    def _free(self) -> Bounds:
        """Bounds before any pattern is imposed."""
        return physical_bounds(self.scenario, self.layout)

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
        contact.fix_contacts(layout, pattern, lower, upper, self.scenario.swing_clearance)
        lower_rows, upper_rows = self._free.lower_rows.copy(), self._free.upper_rows.copy()
        constant = constant_rows(self.scenario, layout, pattern, self.ng)
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
        big_m += layout.phases * layout.legs if layout.linear_forces else 0
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
    """Build the program of a scenario; scenarios with equal problems share it."""
    data = scenario.problem_data
    shared = _Shared(json.dumps(data, sort_keys=True), scenario)
    return GaitProblem(scenario, Layout.of(scenario.as_data()), *_program(shared))


@dataclass(frozen=True)
class _Shared:
    """A scenario, equal to any other with the same problem."""

    problem: str
    scenario: Scenario = field(compare=False)


@lru_cache(maxsize=KEPT)
def _program(shared: _Shared) -> tuple[SeparableProblem, float]:
    """The program of a problem and its scale of cost. A worker's units mostly have one problem on a few meshes."""
    scenario = shared.scenario
    layout = Layout.of(scenario.as_data())
    scale = _cost_scale(scenario, layout)
    w, parameters = ca.SX.sym("w", layout.nw), ca.SX.sym("task", len(AXES))
    task = task_parameters(scenario.tasks, parameters)
    nodes, times = _Nodes(layout, w, body_of(scenario.robot, task)), _times(layout, w[layout.fractions], task)
    steps = _step_terms(scenario, layout, w, task, nodes, times)
    others = _others(scenario, layout, w, task, nodes, times)

    def program(name: str, steps: Sequence[StepTerms], others: _Others) -> ca.Function:
        cost, groups = _joined(steps, others)
        return ca.Function(name, [w, parameters], [cost / scale, ca.vertcat(*groups)], ["w", "task"], ["cost", "rows"])

    nlp = program("nlp", steps, others)
    rest = program("rest", [steps[0].zeros] * len(steps), replace(others, reaches=list(map(_zeros, others.reaches))))
    first_reach = nlp.numel_out(1) - sum(row.numel() for row in (*others.reaches, *others.rows))
    copies = [Copies(*one_step(scenario, layout, scale), _row_places(steps, layout))]
    if others.reaches:
        copies += reach_copies(scenario, layout, first_reach)
    pieces = Pieces(tuple(copies), rest)
    return SeparableProblem(nlp, _elements(scenario, layout, scale), pieces), scale


def _elements(scenario: Scenario, layout: Layout, scale: float) -> tuple[Element, ...]:
    return energy_elements(scenario, layout, scale) if scenario.objective.energy else ()


def _cost_scale(scenario: Scenario, layout: Layout) -> float:
    """A cost of order one for the solver: the largest weight, forces over the robot's weight."""
    weights = scenario.objective.as_data()
    force = (weights.pop("force") + weights.pop("force_rate", 0.0)) * layout.weight**2
    heat, work = weights.pop("joint_heat", 0.0), weights.pop("joint_work", 0.0)
    weights.pop("swing_reaction", 0.0)  # goes with joint_heat, and is as large
    lever = max(-leg.default_foot[-1] for leg in scenario.robot.legs)
    return max(force, heat * (layout.weight * lever) ** 2, work * layout.weight * lever, *weights.values())


class _Nodes:
    """The nodes of a decision vector, each built once: steps that meet inside a phase share one."""

    def __init__(self, layout: Layout, w: ca.SX, body: Body) -> None:
        self._layout, self._w, self._body = layout, w, body
        self._built: dict[tuple[int, int | None], Node] = {}

    def start(self, step: int) -> Node:
        """The node at a step's start, with the forces there."""
        layout = self._layout
        return self._node((step, None), step, [layout.force(step, leg) for leg in range(layout.legs)])

    def end(self, step: int) -> Node:
        """The node at a step's end, with the step's own forces there."""
        layout = self._layout
        if layout.linear_forces and (step + 1) % layout.knots_per_phase:
            return self.start(step + 1)
        return self._node((step + 1, step), step + 1, [layout.end_force(step, leg) for leg in range(layout.legs)])

    def _node(self, key: tuple[int, int | None], knot: int, forces: list[slice]) -> Node:
        if key not in self._built:
            layout, w = self._layout, self._w
            state = w[layout.state(knot)]
            self._built[key] = node(
                self._body,
                state[: layout.nb],
                ca.vertsplit(state[layout.nb :], layout.dimension),
                [w[force] * layout.weight for force in forces],
            )
        return self._built[key]


@dataclass(frozen=True, eq=False)
class _Others:
    """What is not of a step: cost, unscaled, the cones of end forces by phase, the legs' reaches, and the last rows."""

    cost: ca.SX
    cones: list[ca.SX]
    reaches: list[ca.SX]
    rows: list[ca.SX]


def _joined(steps: Sequence[StepTerms], others: _Others) -> tuple[ca.SX, list[ca.SX]]:
    """Cost and the row groups that both forms share; at the end of each phase come the cones of its end forces."""
    cost = sum((step.cost for step in steps), ca.SX(0)) + others.cost
    cones = [step.cones for step in steps]
    for phase in reversed(range(len(others.cones))):
        cones.insert((phase + 1) * len(steps) // len(others.cones), others.cones[phase])
    groups = [[getattr(step, name) for step in steps] for name in ("defects", "offsets", "between")]
    speeds = [step.speeds for step in steps]
    return cost, [*(each for group in groups for each in group), *cones, *speeds, *others.reaches, *others.rows]


def _step_terms(
    scenario: Scenario, layout: Layout, w: ca.SX, task: TaskParameters, nodes: _Nodes, times: list[ca.SX]
) -> list[StepTerms]:
    """The terms of all steps."""
    terms, fractions, cycle = [], w[layout.fractions], task["cycle_duration"]
    for k in range(layout.steps):
        h = cycle * fractions[layout.phase_of(k)] * layout.shares[k % layout.knots_per_phase]
        forces = [w[layout.force(k, leg)] for leg in range(layout.legs)]
        velocities = [w[layout.foot_velocity(k, leg)] for leg in range(layout.legs)]
        step = Step(nodes.start(k), nodes.end(k), (times[k], times[k + 1]), h, forces, velocities)
        terms.append(step_terms(scenario, task, step))
    return terms


def _others(
    scenario: Scenario, layout: Layout, w: ca.SX, task: TaskParameters, nodes: _Nodes, times: list[ca.SX]
) -> _Others:
    cones, weight = [], scenario.objective.force_rate
    for last in range(layout.knots_per_phase - 1, layout.steps if layout.linear_forces else 0, layout.knots_per_phase):
        forces = [task.into_frame(w[layout.end_force(last, leg)], times[last + 1]) for leg in range(layout.legs)]
        cones.append(friction.friction_rows(task["friction"], forces))
    reaches = _reaches(scenario, layout, w, task, nodes, times) if scenario.follows_swings else []
    closing = periodicity.periodicity_rows(layout, w[layout.state(0)], w[layout.state(layout.steps)], task)
    cost = weight * force_rate(layout, w, task, times) if weight else ca.SX(0)
    return _Others(cost, cones, reaches, [closing, timing.cycle_row(w[layout.fractions])])


def _zeros(rows: ca.SX) -> ca.SX:
    return ca.SX.zeros(rows.numel())


def _row_places(steps: Sequence[StepTerms], layout: Layout) -> NDArray[np.intp]:
    """The places of each step's rows among all [K, m]: numbers are put in order as the rows are."""
    numbers = np.arange(len(steps) * sum(group.numel() for group in steps[0].groups)).reshape(len(steps), -1)
    sizes = np.cumsum([0, *(group.numel() for group in steps[0].groups)])
    numbered = [StepTerms(ca.SX(0), *(ca.SX(row[a:b]) for a, b in pairwise(sizes))) for row in numbers]
    ends = 2 * (layout.dimension - 1) * layout.legs
    cones = [ca.SX.ones(ends) * -1] * (layout.phases if layout.linear_forces else 0)
    _, groups = _joined(numbered, _Others(ca.SX(0), cones, [], []))
    order = ca.evalf(ca.vertcat(*groups)).full().ravel().astype(np.intp)
    places = np.empty(numbers.size, dtype=np.intp)
    places[order[order >= 0]] = np.flatnonzero(order >= 0)
    return places.reshape(numbers.shape)


def _reaches(
    scenario: Scenario, layout: Layout, w: ca.SX, task: TaskParameters, nodes: _Nodes, times: list[ca.SX]
) -> list[ca.SX]:
    """The reach of every leg at the end of every phase; a row means something where the leg's contact changes."""
    rows = []
    for leg in range(layout.legs):
        contacts = w[layout.contacts(leg)]
        around = ca.vertcat(w[layout.fractions], contacts)
        for phase in range(layout.phases):
            last = (phase + 1) * layout.knots_per_phase - 1
            side, end = contacts[phase] - contacts[(phase + 1) % layout.phases], nodes.end(last)
            rows.append(leg_reach(scenario, task, leg, end, end.feet[leg], times[last + 1], around, side))
    return rows


def _foot_velocities(layout: Layout, w: ca.SX, task: TaskParameters, times: list[ca.SX], step: int) -> list[ca.SX]:
    """Velocities [d] m/s of the feet in the directions of the commanded frame, in the middle of a step."""
    middle = (times[step] + times[step + 1]) / 2
    return [task.into_frame(w[layout.foot_velocity(step, leg)], middle) for leg in range(layout.legs)]


def _times(layout: Layout, fractions: ca.SX, task: TaskParameters) -> list[ca.SX]:
    """Times [s] of the knots in the cycle."""
    cycle = task["cycle_duration"]
    times, reached = [ca.SX(0)], ca.SX(0)
    for phase in range(layout.phases):
        inner = np.cumsum(layout.shares)
        times += [cycle * (reached + fractions[phase] * float(share)) for share in inner]
        reached += fractions[phase]
    return times


def _minlp(scenario: Scenario, layout: Layout, cost_scale: float) -> ca.Function:
    contacts = layout.legs * layout.phases
    w, parameters = ca.SX.sym("w", layout.nw + contacts), ca.SX.sym("task", len(AXES))
    task = task_parameters(scenario.tasks, parameters)
    nodes, times = _Nodes(layout, w, body_of(scenario.robot, task)), _times(layout, w[layout.fractions], task)
    steps = _step_terms(scenario, layout, w, task, nodes, times)
    cost, groups = _joined(steps, _others(scenario, layout, w, task, nodes, times))
    cost = cost / cost_scale + sum((e.cost(w, parameters) for e in _elements(scenario, layout, cost_scale)), ca.SX(0))
    c = ca.reshape(w[layout.nw :], layout.phases, layout.legs)
    for k in range(layout.steps):
        forces = [w[layout.force(k, leg)] for leg in range(layout.legs)]
        u = ca.vertcat(*forces, *_foot_velocities(layout, w, task, times, k))
        groups.append(contact.big_m_rows(scenario.robot, layout, w[layout.state(k)], u, c[layout.phase_of(k), :].T))
    if layout.linear_forces:
        for phase in range(layout.phases):
            last = (phase + 1) * layout.knots_per_phase - 1
            forces = [w[layout.end_force(last, leg)] for leg in range(layout.legs)]
            groups.append(contact.end_force_rows(scenario.robot, layout, forces, c[phase, :].T))
    if scenario.stances_per_leg == 1:
        rows, _, _ = contact.one_stance_rows(layout.legs, layout.phases)
        groups.append(ca.DM(rows) @ w[layout.nw :])
    return ca.Function("minlp", [w, parameters], [cost, ca.vertcat(*groups)], ["w", "task"], ["cost", "rows"])
