"""A motion at any time: position from the forces, feet from the contacts, cycle after cycle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from gaitflow.core.rigid_body import Attitude, RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion.arguments import (
    checked_apex,
    checked_count,
    checked_span,
    checked_time,
    checked_times,
    leg_number,
)
from gaitflow.motion.body import Path, integrated
from gaitflow.motion.cycles import Cycles, Pair, paired, unpaired
from gaitflow.motion.frames import Frames
from gaitflow.motion.leg import Foot, Leg
from gaitflow.motion.orientation import Turning, angular_velocity, at_base_link, quaternions
from gaitflow.motion.stances import Stance
from gaitflow.motion.state import State

Point = Literal["com", "base"]
SWING_APEX = 0.05  # m


@dataclass(frozen=True, eq=False)
class Motion:
    """A planned cycle repeated without end, as a function of time; build it with `Plan.motion` or `Motion.of`.

    Time 0 is the start of the planned cycle; any finite time may be asked for, before it, too. World frame: the plan's,
    x along the ground, z normal to it. After each cycle everything is turned and displaced by the commanded twist, and
    velocities are raised by the commanded acceleration times T. period [s] is T; dimension d is 2 or 3.

    *Body.* The acceleration is that of the planned forces; velocity and position are its integrals and do not jump,
    also where the plan was made by Euler's rule, whose knots they pass within millimetres. The orientation is smooth:
    cubic angles through the knots' orientations and angular velocities.

    *Feet.* A foot in stance is at rest. Swings leave and land at rest, without acceleration. A plan that is not
    feasible has its faults here, too.

    *The plan*: `scenario`, JSON data, `trajectory`, `task` and `pattern`, as `Motion.of` was given them; swing_apex [m]
    and `point` as well.
    """

    period: float
    dimension: int
    leg_names: tuple[str, ...]
    scenario: Mapping[str, Any] = field(repr=False)
    trajectory: Trajectory = field(repr=False)
    task: Task
    pattern: str
    swing_apex: float | None
    point: Point
    _cycles: Cycles = field(repr=False)
    _path: Path = field(repr=False)
    _turning: Turning = field(repr=False)
    _yaw: float = field(repr=False)  # rad a cycle
    _legs: tuple[Leg, ...] = field(repr=False)
    _forces: Pair = field(repr=False)  # [2, K, legs, 2] at both ends of each step, N
    _centre: Array | None = field(repr=False)  # of mass in the base link's frame [3] m, where that is asked for

    @classmethod
    def of(
        cls,
        scenario: Mapping[str, Any],
        trajectory: Trajectory,
        task: Task,
        pattern: str,
        swing_apex: float | None = SWING_APEX,
        point: Point = "com",
    ) -> Motion:
        """The motion of a trajectory with the contacts `pattern`, "0110/1100", of a scenario's JSON data.

        swing_apex is how high a swing leads above the higher one of its two footholds [m]; None keeps the plan's own
        feet, which move in straight lines between knots. point: whether position, velocity and acceleration are those
        of the centre of mass or of the base link's frame. Raises ValueError for another apex or point, and for "base"
        of a robot whose frames the scenario does not know.
        """
        if point not in ("com", "base"):
            raise ValueError(f'point = {point!r}: must be "com", the centre of mass, or "base", the base link')
        robot, settings = scenario["robot"], scenario["transcription"]
        frames = Frames.of(scenario)
        if point == "base" and frames is None:
            raise ValueError(
                f'point = "base": the map {scenario.get("name")} does not know its robot\'s base link: import the '
                'robot again by `gaitflow robot import` and publish the map anew, or ask for point = "com"'
            )
        apex = checked_apex(swing_apex)
        body, period = RigidBody.of(robot, task), task.cycle_duration
        cycles = Cycles.of(task, period)
        times = trajectory.times.copy()
        times[-1] = period  # to the last bit
        if not (np.diff(times) > 0).all():
            raise ValueError(
                f"the plan's knots do not rise from 0 to {period:g} s: no motion; ask for plan.feasible first"
            )
        position, angles, velocity, omega = body.split(trajectory.base)
        rates = Attitude(angles).rates(omega)
        yaw = task["yaw_rate"] * period if body.dimension == 3 else 0.0
        angles, rates = angles.copy(), rates.copy()
        angles[-1], rates[-1] = angles[0], rates[0]
        angles[-1, 0] += yaw
        feet = paired(trajectory.feet)
        return cls(
            period=period,
            dimension=body.dimension,
            leg_names=tuple(str(leg.get("name", number)) for number, leg in enumerate(robot["legs"])),
            scenario=scenario,
            trajectory=trajectory,
            task=task,
            pattern=pattern,
            swing_apex=apex,
            point=point,
            _cycles=cycles,
            _path=integrated(
                times,
                paired(body.acceleration(trajectory.forces)),
                paired(body.acceleration(trajectory.end_forces)),
                paired(position)[0],
                paired(velocity)[0],
                cycles,
            ),
            _turning=Turning(times, angles, rates),
            _yaw=yaw,
            _legs=tuple(
                Leg.of(row, times, feet[:, leg], int(settings["knots_per_phase"]), cycles, apex)
                for leg, row in enumerate(pattern.split("/"))
            ),
            _forces=paired(np.stack([trajectory.forces, trajectory.end_forces])),
            _centre=np.array(frames.com_in_base) if point == "base" and frames is not None else None,
        )

    def at(self, time: float) -> State:
        """The state at a time [s]. Raises ValueError for a time that is no finite number."""
        sampled = self.sample([checked_time(time)])
        return State(**{each.name: getattr(sampled, each.name)[0] for each in fields(State)})

    def sample(self, times: ArrayLike) -> State:
        """The states at times [n] s, in any order: every array with a leading axis n.

        Raises ValueError for times that are no finite numbers, or more than a list of them.
        """
        asked = checked_times(times)
        numbers, since = self._cycles.split(asked)
        places = self._cycles.places(numbers)
        place = places.of(numbers)
        position, velocity, acceleration = self._body(since, place)
        angles, rates, second = self._turning.at(since)
        angles[:, 0] += self._yaw * numbers
        omega = angular_velocity(angles, rates)
        if self._centre is not None:
            position, velocity, acceleration = at_base_link(
                self._centre, (angles, rates, second), (position, velocity, acceleration)
            )
        found = [leg.at(numbers, since, places, self._cycles) for leg in self._legs]
        contact, feet, speeds, pushes, waits = (
            np.stack([getattr(foot, each.name) for foot in found], axis=1) for each in fields(Foot)
        )
        return State(
            time=asked,
            position=position,
            velocity=velocity,
            acceleration=acceleration,
            orientation=quaternions(angles),
            angular_velocity=omega,
            contact=contact,
            feet=unpaired(feet, self.dimension),
            foot_velocities=unpaired(speeds, self.dimension),
            foot_accelerations=unpaired(pushes, self.dimension),
            forces=self._forces_at(since, place[1]),
            until_touchdown=waits,
        )

    def phases(self, leg: str | int, cycles: int = 1, span: tuple[float, float] | None = None) -> list[Stance]:
        """When and where a leg, by its name or number, stands in the first `cycles` cycles: (start, end, foothold [d]).

        Every stance that reaches into them, in order: the first may begin before 0, the last may end after them. With
        a span (start, stop) [s] they are those that reach into it instead. A leg that always stands has one stance
        without end, one that never stands has none. Raises ValueError for a leg that the robot does not have, a number
        of cycles that is not 1 or more, and a span that does not go from one time to a later one.
        """
        start, stop = (0.0, checked_count(cycles) * self.period) if span is None else checked_span(span)
        stances = self._legs[leg_number(leg, self.leg_names)].stances
        return [
            Stance(begin, end, unpaired(foothold, self.dimension))
            for begin, end, foothold in stances.during(start, stop, self._cycles)
        ]

    @property
    def base_centre(self) -> Array | None:
        """The centre of mass in the base link's frame [3] m, where `point` is "base"; None otherwise."""
        return self._centre

    def of_mass(self) -> Motion:
        """The same motion with the position of the centre of mass, whichever point was asked for."""
        return replace(self, point="com", _centre=None)

    def _body(self, since: Array, place: Pair) -> tuple[Array, Array, Array]:
        position, velocity, acceleration = self._path.at(since)
        origin, turn, drift = place
        return (
            unpaired(origin + turn * position + drift * since[:, None], self.dimension),
            unpaired(turn * velocity + drift, self.dimension),
            unpaired(turn * acceleration, self.dimension),
        )

    def _forces_at(self, since: Array, turn: Pair) -> Array:
        times = self._path.times
        step = np.searchsorted(times[1:-1], since, side="right")
        s = ((since - times[step]) / (times[step + 1] - times[step]))[:, None, None]
        first, last = self._forces[:, step]
        return unpaired(turn[:, None] * (first + s * (last - first)), self.dimension)
