"""A motion that begins at another time and elsewhere."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from gaitflow.motion.arguments import checked_times
from gaitflow.motion.motion import Motion
from gaitflow.motion.place import Place
from gaitflow.motion.stances import Stance
from gaitflow.motion.state import State

ROUNDING = 1e-9  # of a cycle


@dataclass(frozen=True, eq=False)
class Placed:
    """A motion whose time 0 is at `later` [s], and whose world frame is at `place` in the world."""

    motion: Motion
    place: Place
    later: float

    @classmethod
    def commanded_from(cls, motion: Motion, place: Place, time: float, since: float) -> Placed:
        """The motion that is `since` s into its cycle at a time [s], the frame of its command being at `place` then."""
        return cls(motion, place.of(Place.commanded(motion.task, since).inverse), time - since)

    def sample(self, times: ArrayLike) -> State:
        """The states at times [n] s, as of `Motion.sample`."""
        asked = checked_times(times)
        seen, place = self.motion.sample(asked - self.later), self.place
        return replace(
            seen,
            time=asked,
            position=place.points(seen.position),
            velocity=place.directions(seen.velocity),
            acceleration=place.directions(seen.acceleration),
            orientation=place.orientations(seen.orientation),
            feet=place.points(seen.feet),
            foot_velocities=place.directions(seen.foot_velocities),
            foot_accelerations=place.directions(seen.foot_accelerations),
            forces=place.directions(seen.forces),
        )

    def phases(self, leg: str | int, span: tuple[float, float]) -> list[Stance]:
        """The stances of a leg that reach into a span (start, stop) [s], as of `Motion.phases`."""
        start, stop = span
        return [
            Stance(begin + self.later, end + self.later, self.place.points(foothold))
            for begin, end, foothold in self.motion.phases(leg, span=(start - self.later, stop - self.later))
        ]

    def of_mass(self) -> Placed:
        """The same with the position of the centre of mass, whichever point was asked for."""
        return replace(self, motion=self.motion.of_mass())

    def next_time(self, since: float, after: float) -> float:
        """The first time [s] from `after` on at which the cycle is `since` [s] old; `after` itself while it stands."""
        if "0" not in self.motion.pattern:
            return after
        period, first = self.motion.period, self.later + since
        return first + period * math.ceil((after - first) / period - ROUNDING)

    def commanded(self, time: float) -> Place:
        """Where the frame that follows the command is at a time [s]."""
        return self.place.of(Place.commanded(self.motion.task, time - self.later))
