"""The way from one motion to another: planned once, followed once."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import ArrayLike

from gaitflow.core.rigid_body import Attitude, RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion.arguments import checked_time, checked_times
from gaitflow.motion.body import Path, between
from gaitflow.motion.cycles import Pair, paired, unpaired
from gaitflow.motion.orientation import Turning, angular_velocity, at_base_link, quaternions
from gaitflow.motion.phase_start import PhaseStart
from gaitflow.motion.place import Place
from gaitflow.motion.placed import Placed
from gaitflow.motion.state import State
from gaitflow.motion.transition_leg import FootCourse, Sampled, TransitionLeg


@dataclass(frozen=True, eq=False)
class PlannedTransition:
    """A transition as it is planned, in the frame that follows the first motion's command at its start.

    first, last: where the two gaits are left and joined. task: the mean of both commands, an acceleration from the one
    speed to the other, and the transition's duration in place of a cycle's. cost is by the objective of transitions;
    violation is the worst scaled one by `gaitflow.core.check`, with the two states in place of periodicity.
    """

    first: PhaseStart
    last: PhaseStart
    pattern: str
    task: Task
    trajectory: Trajectory
    cost: float
    violation: float


@dataclass(frozen=True, eq=False)
class Transition:
    """A planned transition in time and in the world, from `start` to `end` [s]; `plan` says what was planned.

    Position, velocity, orientation and angular velocity begin as those of the motion ahead and end as those of the
    motion behind. A foot that is in the air at the start is led on to its next foothold of the transition; one that is
    in the air at the end, to its foothold of the motion behind.
    """

    start: float
    end: float
    plan: PlannedTransition
    legs: tuple[TransitionLeg, ...] = field(repr=False)
    _place: Place = field(repr=False)
    _path: Path = field(repr=False)
    _turning: Turning = field(repr=False)
    _centre: Array | None = field(repr=False)

    @classmethod
    def of(cls, plan: PlannedTransition, start: float, ahead: Placed, before: Sampled, behind: Placed) -> Transition:
        """The transition from a motion `ahead` to one `behind` it, from a time `start` [s] on.

        `before` has the feet up to there: the motion ahead or the journey that led to it.
        """
        motion, trajectory = ahead.motion, plan.trajectory
        place, end = ahead.commanded(start), start + plan.task.cycle_duration
        body = RigidBody.of(motion.scenario["robot"], plan.task)
        first, last = ahead.of_mass().sample([start]), behind.of_mass().sample([end])
        accelerations = (
            paired(place.directions(body.acceleration(trajectory.forces))),
            paired(place.directions(body.acceleration(trajectory.end_forces))),
        )
        _, angles, _, omega = body.split(place.bodies(trajectory.base))
        steps = len(trajectory.forces) // len(trajectory.durations)
        edges, feet = start + trajectory.times[::steps], place.points(trajectory.feet[::steps])
        edges[-1] = end
        return cls(
            start=start,
            end=end,
            plan=plan,
            legs=tuple(
                TransitionLeg.of(
                    leg, row, edges, feet[:, leg],
                    (bool(plan.first.contacts[-1, leg]), bool(plan.first.contacts[0, leg])),
                    before, behind, motion.swing_apex or 0.0,
                )
                for leg, row in enumerate(plan.pattern.split("/"))
            ),
            _place=place,
            _path=between(trajectory.times, *accelerations, _pair_of(first), _pair_of(last)),
            _turning=Turning(trajectory.times, angles, Attitude(angles).rates(omega)),
            _centre=motion.base_centre,
        )  # fmt: skip

    def at(self, time: float) -> State:
        """The state at a time [s] of the transition. Raises ValueError for any other time."""
        sampled = self.sample([checked_time(time)])
        return State(**{each.name: getattr(sampled, each.name)[0] for each in fields(State)})

    def sample(self, times: ArrayLike) -> State:
        """The states at times [n] s of the transition. Raises ValueError for any other times."""
        asked = checked_times(times)
        outside = np.flatnonzero((asked < self.start) | (asked > self.end))
        if outside.size:
            raise ValueError(
                f"times[{outside[0]}] = {asked[outside[0]]:g}: the transition is from {self.start:g} to {self.end:g} s"
            )
        since = np.minimum(asked - self.start, self._turning.times[-1])
        dimension = self.plan.trajectory.feet.shape[-1]
        turning = self._turning.at(since)
        angles, rates, _ = turning
        position, velocity, acceleration = (unpaired(each, dimension) for each in self._path.at(since))
        if self._centre is not None:
            position, velocity, acceleration = at_base_link(self._centre, turning, (position, velocity, acceleration))
        course = self.feet(asked)
        return State(
            time=asked,
            position=position,
            velocity=velocity,
            acceleration=acceleration,
            orientation=quaternions(angles),
            angular_velocity=angular_velocity(angles, rates),
            forces=self._forces_at(since),
            contact=course.contact,
            feet=course.feet,
            foot_velocities=course.foot_velocities,
            foot_accelerations=course.foot_accelerations,
            until_touchdown=course.until_touchdown,
        )

    def feet(self, times: Array) -> FootCourse:
        """All feet at times [n] s: arrays [n, legs, ...]. A leg that has joined by then is not there any more."""
        by_leg = [vars(leg.at(times)) for leg in self.legs]
        return FootCourse(**{name: np.stack([course[name] for course in by_leg], axis=1) for name in by_leg[0]})

    def _forces_at(self, since: Array) -> Array:
        plan = self.plan.trajectory
        step = np.searchsorted(plan.times[1:-1], since, side="right")
        s = ((since - plan.times[step]) / np.diff(plan.times)[step])[:, None, None]
        return self._place.directions(plan.forces[step] + s * (plan.end_forces - plan.forces)[step])


def _pair_of(state: State) -> tuple[Pair, Pair]:
    """Position and velocity [2] of a single state."""
    return paired(state.position)[0], paired(state.velocity)[0]
