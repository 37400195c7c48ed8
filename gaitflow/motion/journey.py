"""A motion, a transition, another motion: one motion at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike

from gaitflow.core.trajectory import Array
from gaitflow.motion.arguments import checked_span, checked_time, checked_times, leg_number
from gaitflow.motion.motion import Motion, Point
from gaitflow.motion.place import Place
from gaitflow.motion.placed import Placed
from gaitflow.motion.stances import SHORTLY, Stance, connected, within
from gaitflow.motion.state import State
from gaitflow.motion.transition import PlannedTransition, Transition
from gaitflow.motion.transition_leg import FootCourse


@dataclass(frozen=True, eq=False)
class Journey:
    """A robot that changes its gait, as a function of time: `before`, then `transition`, then `after`.

    `before` is a motion or the journey so far, in whose world and time the whole journey is; `after` is the other
    motion from the transition's end on. Position, orientation, their velocities, and feet with their velocities and
    accelerations do not jump anywhere; forces do, as between phases.
    """

    before: Motion | Journey
    transition: Transition
    after: Placed

    @classmethod
    def of(cls, before: Motion | Journey, plan: PlannedTransition, start: float, other: Motion) -> Journey:
        """The journey that leaves `before` at a time `start` [s], by a planned transition to another motion.

        The time is one at which the phase begins that is left, and of a journey none before it has settled.
        """
        ahead = last_of(before)
        end = start + plan.task.cycle_duration
        place = ahead.commanded(start).of(Place.commanded(plan.task, plan.task.cycle_duration))
        after = Placed.commanded_from(other, place, end, plan.last.since)
        return cls(before, Transition.of(plan, start, ahead, before, after), after)

    @property
    def settled(self) -> float:
        """From when on [s] everything, feet in the air too, is the other motion's; the transition's end or later."""
        return max(leg.joined for leg in self.transition.legs)

    @property
    def leg_names(self) -> tuple[str, ...]:
        """The names of the legs, in the order of every array."""
        return self.after.motion.leg_names

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return self.after.motion.dimension

    @property
    def point(self) -> Point:
        """What position, velocity and acceleration are of, as of `Motion`."""
        return self.after.motion.point

    def at(self, time: float) -> State:
        """The state at a time [s], as of `Motion.at`."""
        sampled = self.sample([checked_time(time)])
        return State(**{each.name: getattr(sampled, each.name)[0] for each in fields(State)})

    def sample(self, times: ArrayLike) -> State:
        """The states at times [n] s, as of `Motion.sample`."""
        asked = checked_times(times)
        early, late = asked < self.transition.start, asked >= self.transition.end
        pieces = ((late, self._after), (~early & ~late, self.transition.sample), (early, self._before))
        # Nobody asks the motions of long ago for the times of today.
        parts = [(np.flatnonzero(mask), piece(asked[mask])) for mask, piece in pieces if mask.any()]
        if not parts:
            return self._after(asked)
        back = np.argsort(np.concatenate([places for places, _ in parts]))
        return State(
            **{
                each.name: np.concatenate([getattr(state, each.name) for _, state in parts])[back]
                for each in fields(State)
            }
        )

    def phases(self, leg: str | int, span: tuple[float, float]) -> list[Stance]:
        """When and where a leg, by its name or number, stands: (start, end, foothold [d]), as of `Motion.phases`.

        Every stance that reaches into a span (start, stop) [s], in order: the first may begin before it, the last may
        end after it. Raises ValueError for a leg that the robot does not have, and for a span that does not go from one
        time to a later one.
        """
        start, stop = checked_span(span)
        number = leg_number(leg, self.leg_names)
        left, course = self.transition.start, self.transition.legs[number]
        joined = course.joined
        behind = self.after.phases(number, (max(start, joined), max(stop, joined + SHORTLY)))
        found = connected([*course.stances, *within(behind, joined, math.inf)])
        if start < left or any(begin <= left < end and end > start for begin, end, _ in found):
            # A stance that began before the transition is one with the rest of it.
            ahead = self.before.phases(number, span=(min(start, left - SHORTLY), left))
            found = connected([*within(ahead, -math.inf, left), *found])
        return [stance for stance in found if stance.start < stop and stance.end > start]

    def _before(self, times: Array) -> State:
        """Before the transition: touchdowns after its start are its own."""
        seen, start = self.before.sample(times), self.transition.start
        firsts = np.array([leg.first_touchdown for leg in self.transition.legs])
        waits = seen.until_touchdown
        kept = times[:, None] + waits < start - 1e-9
        return replace(seen, until_touchdown=np.where(kept, waits, firsts - times[:, None]))

    def _after(self, times: Array) -> State:
        """After the transition: legs that have not joined yet end their swings."""
        seen = self.after.sample(times)
        joined = np.array([leg.joined for leg in self.transition.legs])
        away = times[:, None] < joined
        if not away.any():
            return seen
        course = self.transition.feet(times)

        chosen = {}
        for name in (each.name for each in fields(FootCourse)):
            own, other = getattr(course, name), getattr(seen, name)
            chosen[name] = np.where(away if own.ndim == 2 else away[..., None], own, other)
        return replace(seen, **chosen)


def last_of(motion: Motion | Journey) -> Placed:
    """The motion that goes on at the end."""
    return motion.after if isinstance(motion, Journey) else Placed(motion, Place(), 0.0)
