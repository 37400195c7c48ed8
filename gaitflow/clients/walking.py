"""Walk: a robot in MuJoCo that follows a motion, and what is measured of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gaitflow.clients.body_target import heading
from gaitflow.clients.controller import CONTROL_STEP, Controller
from gaitflow.clients.dynamics import Dynamics
from gaitflow.clients.record import Moment, WalkRecord, record_of
from gaitflow.clients.reference import Followed, one_of
from gaitflow.clients.robot_model import BASE, PHYSICS_STEP, RobotModel
from gaitflow.clients.rotation import turned
from gaitflow.clients.simulation import AS_PLANNED, Conditions, Simulation
from gaitflow.core.trajectory import Array
from gaitflow.motion import State

LEAST_HEIGHT = 0.6  # of the standing height: lower is fallen
MOST_TILT = 0.7  # rad
FRAMES_PER_SECOND = 30
SETTLING = 2  # cycles before the measured part


class Cyclic(Followed, Protocol):
    """A motion with a cycle's duration [s]."""

    @property
    def period(self) -> float:
        """A cycle's duration [s]."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The robot at a time [s], to be drawn: base position [3] m and orientation [4] (w, x, y, z), each leg's joints
    and foot [legs, 4, 3] m, the ground's forces on the feet [legs, 3] N."""

    time: float
    position: Array
    orientation: Array
    points: Array
    forces: Array


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk's record, its frames, 30 a second from its start, and which feet touched after each ms [n, legs]."""

    record: WalkRecord
    frames: tuple[Frame, ...]
    touching: NDArray[np.bool_]


class Walker:
    """A robot in physics with its controller, which `advance` moves on by a control step of 2 ms.

    It begins at time 0 in the motion's own state: base and feet where the motion has them, at its velocities. The
    motion, a `Motion` or a `Journey`, has `point="base"`; another one may be followed from any time on, which should be
    where the one before is. Raises ValueError for a motion in the plane or one of the centre of mass.
    """

    def __init__(self, robot: RobotModel, motion: Followed, conditions: Conditions = AS_PLANNED) -> None:
        self.robot, self.motion = robot, motion
        position, velocity = started(robot, motion)
        self.simulation = Simulation(robot, position, velocity, conditions)
        self.controller = Controller(robot, motion)

    def follow(self, motion: Followed) -> None:
        """Follow another motion from now on."""
        self.motion = motion
        self.controller.follow(motion, self.time)

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self.simulation.time

    @property
    def fallen(self) -> bool:
        """Whether the base is below 60 % of its standing height, or tilted by more than 0.7 rad."""
        measured = self.simulation.measured
        height = measured.position[2] - self.robot.ground
        low = height < LEAST_HEIGHT * self.robot.height
        return bool(low or _tilt(measured.position[3:7]) > MOST_TILT or not np.isfinite(measured.position).all())

    def advance(self) -> list[Moment]:
        """One control step; what was measured after each physics step."""
        simulation = self.simulation
        state = self.controller.reference(simulation.time).state
        torque = self.controller.torque(simulation.measured)
        moments = []
        for _ in range(round(CONTROL_STEP / PHYSICS_STEP)):
            simulation.step(torque)
            moments.append(self._moment(state))
        return moments

    @property
    def frame(self) -> Frame:
        """The robot now, to be drawn."""
        measured = self.simulation.measured
        return Frame(
            self.time,
            measured.position[:3],
            measured.position[3:7],
            self.simulation.points,
            self.simulation.forces.copy(),
        )

    def _moment(self, state: State) -> Moment:
        simulation, measured = self.simulation, self.simulation.measured
        later = simulation.time - float(state.time)
        return Moment(
            time=simulation.time,
            position=measured.position[:3],
            velocity=measured.velocity[:3],
            tilt=_tilt(measured.position[3:7]),
            joint_velocity=measured.velocity[BASE:],
            torque=simulation.torque,
            saturated=bool((np.abs(simulation.torque) >= 0.999 * self.robot.effort).any()),
            heading=heading(measured.position[3:7]),
            forces=simulation.forces,
            sliding=simulation.sliding(),
            planned_position=state.position + later * state.velocity,
            planned_velocity=state.velocity + later * state.acceleration,
            planned_heading=heading(state.orientation),
        )


def walk(
    robot: RobotModel,
    motion: Cyclic,
    cycles: int = 10,
    conditions: Conditions = AS_PLANNED,
    each: Callable[[Walker], None] | None = None,
) -> Walk:
    """Walk `cycles` measured cycles of a motion, after two that are not; `each` is called before every control step.

    A robot that falls walks no further. Raises ValueError as `Walker`.
    """
    if cycles < 1:
        raise ValueError(f"cycles = {cycles}: must be at least 1")
    walker = Walker(robot, motion, conditions)
    moments: list[Moment] = []
    frames: list[Frame] = []
    begin, end = SETTLING * motion.period, (SETTLING + cycles) * motion.period
    fell = None
    while walker.time < end - PHYSICS_STEP / 2:
        if each is not None:
            each(walker)
        if walker.time * FRAMES_PER_SECOND >= len(frames) - 1e-6:
            frames.append(walker.frame)
        moments += walker.advance()
        if walker.fallen:
            fell = walker.time
            break
    measured = [moment for moment in moments if moment.time > begin] or moments
    touching = np.array([moment.forces[:, 2] > 0 for moment in moments])
    return Walk(record_of(measured, PHYSICS_STEP, robot.mass, fell), tuple(frames), touching)


def started(robot: RobotModel, motion: Followed) -> tuple[Array, Array]:
    """Positions [7 + joints] and velocities [6 + joints] of a robot at a motion's time 0. Raises ValueError."""
    state = one_of(motion.sample([0.0]), 0)
    if len(state.position) != 3:
        raise ValueError("a planar motion: a robot of a URDF walks in space; use a map whose robot has dimension 3")
    if getattr(motion, "point", "base") != "base":
        raise ValueError('a motion of the centre of mass: ask for plan.motion(point="base")')
    dynamics = Dynamics(robot)
    base = np.concatenate([state.position, state.orientation])
    centres = state.feet + turned(np.stack([leg.standing for leg in robot.legs]), heading(state.orientation))
    position = dynamics.posed(base, centres)
    velocity = np.zeros(robot.physics.nv)
    velocity[:3], velocity[3:6] = state.velocity, state.angular_velocity
    at = dynamics.at(position, velocity, state.contact)
    for leg, jacobian, speed in zip(robot.legs, at.jacobian, state.foot_velocities, strict=True):
        velocity[leg.velocities] = np.linalg.lstsq(
            jacobian[:, leg.velocities], speed - jacobian[:, :BASE] @ velocity[:BASE], rcond=None
        )[0]
    return position, velocity


def _tilt(orientation: Array) -> float:
    """Of the base's z from the world's [rad]."""
    _, x, y, _ = orientation
    return float(np.arccos(np.clip(1 - 2 * (x * x + y * y), -1.0, 1.0)))
