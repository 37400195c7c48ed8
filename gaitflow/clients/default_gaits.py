"""The gaits everybody starts with, made by hand: trot, walk, pace and bound of a quadruped, to compare plans with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.layout import Layout
from gaitflow.core.names import quadruped_places
from gaitflow.core.rigid_body import RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.core.twist import displacements, headings, velocities
from gaitflow.motion import Motion, Point
from gaitflow.motion.motion import SWING_APEX

Kind = Literal["trot", "walk", "pace", "bound"]
PHASES = 4
# Legs left front, right front, left hind, right hind: which of them land first, which half a cycle later.
PAIRS = {"trot": ((0, 3), (1, 2)), "pace": ((0, 2), (1, 3)), "bound": ((2, 3), (0, 1))}
LATERAL_SEQUENCE = (2, 0, 3, 1)  # they land a quarter of a cycle apart
WALKING_DUTIES = (0.25, 0.5, 0.75)


def default_motion(
    scenario: Mapping[str, Any],
    kind: Kind,
    task: Task,
    duty: float,
    swing_apex: float = SWING_APEX,
    point: Point = "base",
) -> Motion:
    """A gait of this kind at a task for the quadruped of a scenario's JSON data; the first leg lands at time 0.

    duty is the part of the cycle that each foot stands. Each foothold lies under the foot's default place in the body
    at the middle of its stance, Raibert's symmetric one. The body is level and moves by the task's twist; all forces
    act against gravity, shared evenly by the feet that stand, constant as long as any does, and carry the weight in the
    mean over the cycle. So the body's height is that of standing, but for what it rises and falls about a flight phase;
    moments about the body are not balanced. Above a duty of 0.5 all feet stand in between, below it there is flight. A
    walk is the lateral sequence in four beats, at a duty of 0.25, 0.5 or 0.75, where one leg lands as another lifts.

    swing_apex [m] and point as of `Motion.of`. Raises ValueError for another kind or duty, a robot that is no
    quadruped by its legs' names, a scenario without four phases and a task that gains speed.
    """
    names = [str(leg.get("name")) for leg in scenario["robot"]["legs"]]
    places = quadruped_places(names)
    if places is None or scenario["robot"]["dimension"] != 3:
        raise ValueError(
            f"legs {', '.join(names)}: a hand-made {kind} is for a quadruped in space with legs LF, RF, LH, RH"
        )
    layout, body = Layout.of(scenario), RigidBody.of(scenario["robot"], task)
    if layout.phases != PHASES:
        raise ValueError(f"phases = {layout.phases}: a hand-made gait has {PHASES}; take a scenario that has as many")
    if task["acceleration"] != 0:
        raise ValueError(f"acceleration = {task['acceleration']:g} m/s^2: a hand-made gait keeps its speed, ask for 0")
    stands, parts = _contacts(kind, duty)
    stands = stands[np.argsort(places)]
    pattern = "/".join("".join("1" if down else "0" for down in row) for row in stands)
    trajectory = _level(layout, body, task, stands, parts)
    draft = Motion.of(scenario, trajectory, task, pattern, swing_apex)
    return Motion.of(scenario, _on_knots(draft, layout), task, pattern, swing_apex, point)


def _contacts(kind: str, duty: float) -> tuple[NDArray[np.bool_], Array]:
    """Who stands in which phase [4, 4], legs as in PAIRS, and the phases' parts of the cycle [4]."""
    if kind not in get_args(Kind):
        raise ValueError(f"kind = {kind!r}: the hand-made gaits are {', '.join(get_args(Kind))}")
    if not 0 < duty < 1:
        raise ValueError(f"duty = {duty!r}: the part of the cycle that a foot stands, between 0 and 1")
    stands = np.zeros((4, PHASES), dtype=bool)
    if kind == "walk":
        quarters = round(duty * PHASES)
        if not math.isclose(duty * PHASES, quarters, abs_tol=1e-9) or not 0 < quarters < PHASES:
            listed = ", ".join(f"{each:g}" for each in WALKING_DUTIES)
            raise ValueError(f"duty = {duty:g}: a walk of four phases has one of {listed}")
        for beat, leg in enumerate(LATERAL_SEQUENCE):
            stands[leg, (beat + np.arange(quarters)) % PHASES] = True
        return stands, np.full(PHASES, 1 / PHASES)
    if math.isclose(duty, 0.5, abs_tol=1e-6):  # each half of the cycle in two phases
        rows, parts = ("1100", "0011"), np.full(PHASES, 1 / PHASES)
    elif duty < 0.5:
        rows, parts = ("1000", "0010"), np.array([duty, 0.5 - duty] * 2)
    else:
        rows, parts = ("1110", "1011"), np.array([duty - 0.5, 1 - duty] * 2)
    for pair, row in zip(PAIRS[kind], rows, strict=True):
        stands[list(pair)] = [digit == "1" for digit in row]
    return stands, parts


def _level(layout: Layout, body: RigidBody, task: Task, stands: NDArray[np.bool_], parts: Array) -> Trajectory:
    """The body level at an even height; each foot at the foothold of its one stance, in swing, too."""
    durations = parts * task.cycle_duration
    times = layout.times(durations)
    edges = times[:: layout.knots_per_phase]
    base = np.zeros((len(times), layout.nb))
    base[:, :2] = displacements(task, times)
    base[:, 2] = -body.default_feet[:, 2].mean()
    base[:, 3] = headings(task, times)
    base[:, 6:8] = velocities(task, times)
    base[:, 11] = task["yaw_rate"]
    feet = np.zeros((len(times), layout.legs, 3))
    for leg, row in enumerate(stands):
        landing = next(phase for phase in range(PHASES) if row[phase] and not row[phase - 1])
        middle = edges[landing] + row @ durations / 2
        feet[:, leg, :2] = displacements(task, middle) + _turned(body.default_feet[leg, :2], task["yaw_rate"] * middle)
    anyone = stands.any(axis=0)
    shares = stands / np.maximum(stands.sum(axis=0), 1) / (parts @ anyone)  # [legs, phases]
    forces = np.repeat(shares.T, layout.knots_per_phase, axis=0)[..., None] * (-body.mass * body.gravity)
    return Trajectory(times, base, feet, forces, forces.copy(), np.zeros_like(forces), durations)


def _on_knots(motion: Motion, layout: Layout) -> Trajectory:
    """A motion's trajectory with knots that lie on the motion: its rise and fall, its swings."""
    trajectory = motion.trajectory
    seen, base = motion.sample(trajectory.times), trajectory.base.copy()
    base[:, :3], base[:, 6:9] = seen.position, seen.velocity
    speeds = np.diff(seen.feet, axis=0) / np.diff(trajectory.times)[:, None, None]
    return replace(trajectory, base=base, feet=seen.feet, foot_velocities=speeds)


def _turned(vector: Array, angle: float) -> Array:
    """A vector [2] turned to the left by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
