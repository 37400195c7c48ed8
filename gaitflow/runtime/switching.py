"""Planning a transition: the map's problem between the states of two gaits, solved by the interior point.

The boundary states enter as the pattern does, through bounds: the program is the same for every transition, and is
built once a map.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import islice
from typing import Any

import numpy as np

from gaitflow.core.check import FEASIBLE
from gaitflow.core.check_transition import violations_between
from gaitflow.core.errors import NoTransition
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY, Layout
from gaitflow.core.task import AXES, Task
from gaitflow.core.trajectory import Array
from gaitflow.motion.motion import Motion
from gaitflow.motion.phase_start import phase_starts
from gaitflow.motion.transition import PlannedTransition
from gaitflow.runtime.way import Way, end_states, interpolated
from gaitflow.runtime.ways import ways
from gaitflow.solvers.interior_point import InteriorPoint
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import Program, derivatives

DURATIONS = (1.0, 1.5, 2.0)  # of a transition, over the mean of both cycles'
TRIED, FOUND = 8, 3  # ways that are solved for a duration; how many feasible ones are compared
BARRIER, LIMIT = 0.1, 60  # of a start without multipliers
SMOOTHNESS = 1e3  # weight of a motion that is off by the speed of a fall, over that of forces as large as the weight
PLACES = ("slope", "friction", "payload")  # what both motions must have alike
TURNS = ("lateral_speed", "yaw_rate")


class TransitionProblem:
    """The problem of a map's transitions, shared by all threads: its scenario's, with a speed that changes on the way.

    Raises ImportError without gaitflow[solve].
    """

    def __init__(self, scenario: Mapping[str, Any]) -> None:
        from gaitflow.config.scenario import Scenario
        from gaitflow.problem import transcribe

        name = str(scenario.get("name"))
        own = Scenario.from_data(json.loads(json.dumps(scenario)), name)
        tasks = own.tasks.as_data()
        tasks["axes"]["acceleration"] = {"start": -1.0, "stop": 1.0, "count": 2}  # it varies, by any amount
        # The swings that are followed have a height of their own, and those under way no middle.
        changed: dict[str, Any] = {"tasks": own.tasks.from_data(tasks, name), "swing_clearance": 0.0}
        if own.objective.energy or own.objective.force_rate:  # which are of whole cycles
            changed["objective"] = own.objective.from_data(_smoothness(scenario["robot"]), name)
        self.gait_problem = transcribe(own.model_copy(update=changed))
        self.scenario = self.gait_problem.scenario.as_data()
        self.derivatives = derivatives(self.gait_problem.separable)


class TransitionPlanner:
    """Plans transitions; for one thread."""

    def __init__(self, problem: TransitionProblem) -> None:
        self._problem = problem
        self._program = Program(problem.gait_problem.separable, problem.derivatives)

    def plan(self, motion: Motion, other: Motion) -> PlannedTransition:
        """The cheapest of the first transitions that are found from one motion to another, the shortest first.

        Raises ValueError for motions between which there is none to be looked for, NoTransition when none is found.
        """
        scenario = self._problem.scenario
        firsts, lasts = phase_starts(motion), phase_starts(other)
        mean = (motion.period + other.period) / 2
        for duration in DURATIONS:
            task = self._task(motion, other, duration * mean)
            candidates = ways(scenario, firsts, lasts, task)[:TRIED]
            solved = (self._solved(way, task) for way in candidates)
            found = list(islice((each for each in solved if each is not None), FOUND))
            if found:
                return min(found, key=lambda each: each.cost)
        raise NoTransition(
            f"no transition of {DURATIONS[0] * mean:.3g} to {DURATIONS[-1] * mean:.3g} s from {_described(motion)} to "
            f"{_described(other)} was found; switch by a motion in between, or to a speed that is nearer"
        )

    def _task(self, motion: Motion, other: Motion, duration: float) -> Task:
        """The mean of both commands, and the acceleration from the one speed to the other."""
        one, two = motion.task, other.task
        for axis in PLACES:
            if one[axis] != two[axis]:
                raise ValueError(f"{axis}: {one[axis]:g} and {two[axis]:g}: must be the same for both motions")
        scenario = self._problem.scenario
        for task in (one, two):
            if task["acceleration"]:
                raise ValueError(
                    f"acceleration = {task['acceleration']:g}: a transition leads between motions of constant speed"
                )
            for axis in (*TURNS, *PLACES):
                if task[axis] and scenario["tasks"]["axes"].get(axis, AXES[axis].default) == 0:
                    raise ValueError(f"{axis} = {task[axis]:g}: the map {scenario['name']} holds it at 0")
        values = {axis: (one[axis] + two[axis]) / 2 for axis in ("speed", *TURNS, *PLACES)}
        gained = (two.speed - one.speed) / duration
        return Task.of(values | {"cycle_duration": duration, "acceleration": gained})

    def _solved(self, way: Way, task: Task) -> PlannedTransition | None:
        """The transition of a way, None where the solver does not converge to a feasible one."""
        problem, scenario = self._problem.gait_problem, self._problem.scenario
        layout, duration = problem.layout, task.cycle_duration
        first, last = end_states(way, task)
        bounds = problem.bounds(Pattern.from_text(way.pattern))
        space = _between(
            GaitSpace(bounds.lower, bounds.upper, bounds.lower_rows, bounds.upper_rows), layout, first, last
        )
        start = layout.pack(interpolated(scenario, way, first, last, layout.times(way.durations)), duration)
        cost = float(problem.nlp(start, task.parameters)[0])
        unit = max(cost, (0.1 * GRAVITY * duration) ** 2 * duration / 12)
        nothing = np.zeros(len(space.lower)), np.zeros(len(space.lower_rows))
        point = space.split(start, *nothing, 1.0)
        outcome = InteriorPoint(self._program, space).follow(task.parameters, point, unit, BARRIER, LIMIT, careful=True)
        trajectory = layout.unpack(outcome.w, duration)
        violation = max(violations_between(scenario, trajectory, task, way.pattern, (first, last)).values())
        if not outcome.converged or violation > FEASIBLE:
            return None
        cost = outcome.cost * problem.cost_scale
        return PlannedTransition(way.first, way.last, way.pattern, task, trajectory, cost, violation)


def _smoothness(robot: Mapping[str, Any]) -> dict[str, float]:
    """The weights of J3 for any robot: speeds over those of a fall from its height, forces over its weight."""
    height = max(-leg["default_foot"][-1] for leg in robot["legs"])
    weight, fall = float(robot["mass"]) * GRAVITY, height / GRAVITY
    speed = SMOOTHNESS / (GRAVITY * height)
    return {
        "force": 1 / weight**2,
        "tangential_velocity": speed,
        "normal_velocity": speed,
        "tilt": SMOOTHNESS,
        "tilt_rate": SMOOTHNESS * fall,
        "lateral_foot": SMOOTHNESS / height**2 if robot["dimension"] == 3 else 0.0,
    }


def check_switchable(scenario: Mapping[str, Any], motion: Motion, other: Motion) -> None:
    """Raises ValueError for motions that no transition of a map with this scenario can join."""
    if motion.point != other.point:
        raise ValueError(f"point: {motion.point!r} and {other.point!r}: must be the same for both motions")
    for each in (motion, other):
        _check_alone(scenario, each)


def _check_alone(scenario: Mapping[str, Any], motion: Motion) -> None:
    own, robot = (_mechanics(each["robot"]) for each in (scenario, motion.scenario))
    if own != robot:
        raise ValueError(
            f"a motion of the robot {robot['name']} of {motion.scenario.get('name')}: the transition's map "
            f"{scenario.get('name')} is of another one, {own['name']}"
        )
    if motion.swing_apex is None:
        raise ValueError("swing_apex = None: a transition leads between swings of a height, not between the plan's own")
    for leg, row in zip(motion.leg_names, motion.pattern.split("/"), strict=True):
        if "1" not in row:
            raise ValueError(f"the motion {_described(motion)} never sets down the leg {leg}: no transition joins it")


def _mechanics(robot: Mapping[str, Any]) -> dict[str, Any]:
    """A robot without what no motion depends on."""
    return {key: value for key, value in robot.items() if key not in ("source", "frames", "mirror", "limbs")}


def _between(gait: GaitSpace, layout: Layout, first: Array, last: Array) -> GaitSpace:
    """The bounds of a gait with its first and last state [nx] fixed, instead of periodic.

    Rows of which every variable is fixed thereby are left free: those that close a cycle, and the box at the first
    knot.
    """
    lower, upper = gait.lower.copy(), gait.upper.copy()
    for knot, state in ((0, first), (layout.steps, last)):
        lower[layout.state(knot)] = upper[layout.state(knot)] = state
    lower_rows, upper_rows = gait.lower_rows.copy(), gait.upper_rows.copy()
    defects, rows = layout.steps * layout.nx, len(lower_rows)
    box, closing = slice(defects, defects + layout.legs * layout.dimension), slice(rows - 1 - layout.nx, rows - 1)
    for free in (box, closing):
        lower_rows[free], upper_rows[free] = -np.inf, np.inf
    return GaitSpace(lower, upper, lower_rows, upper_rows)


def _described(motion: Motion) -> str:
    return f"{motion.pattern} at {motion.task.text()}"
