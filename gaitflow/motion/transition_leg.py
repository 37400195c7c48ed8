"""One leg of a transition: where its foot is until it follows the second motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.motion.cycles import Numbers, paired, unpaired
from gaitflow.motion.stances import SHORTLY, Stance
from gaitflow.motion.state import State
from gaitflow.motion.swing import minimum_jerk, swing


class Sampled(Protocol):
    """What has a state at any time."""

    def sample(self, times: Array) -> State:
        """The states at times [n] s."""
        ...


@dataclass(frozen=True, eq=False)
class FootCourse:
    """A foot at n times, the fields of a State: contact [n], until_touchdown [n] s, the others [n, d]; or all feet."""

    contact: NDArray[np.bool_]
    feet: Array
    foot_velocities: Array
    foot_accelerations: Array
    until_touchdown: Array


@dataclass(frozen=True, eq=False)
class TransitionLeg:
    """A leg from the start of a transition [s] until it has `joined` the motion behind [s].

    It stands from starts [s] to ends [s] at footholds [s, d] m, in order; a leg that does not stand at first has one
    stance of no duration there, where its foot is, and so has at the end a leg that joins in the air. A leg in the
    middle of a swing has its course of the motion `before`, where that swing would end at `landing` [s]; otherwise that
    is None. first_touchdown and next_touchdown [s]: the first one from the start on, and the one after all these
    stances.
    """

    number: int
    joined: float
    starts: Array
    ends: Array
    footholds: Array
    before: Sampled
    landing: float | None
    apex: float
    first_touchdown: float
    next_touchdown: float

    @classmethod
    def of(
        cls, number: int, row: str, edges: Array, feet: Array, stood: tuple[bool, bool], before: Sampled,
        behind: Sampled, apex: float,
    ) -> TransitionLeg:  # fmt: skip
        """The leg of a row of the transition's pattern, whose phases begin and end at `edges` [phases + 1] s.

        feet [phases + 1, d] m are the transition's there. stood: whether the leg stands in the motion `before` shortly
        ahead of the start, and would stand shortly after it. Where the motion `behind` has the leg in the middle of a
        swing at the end, it joins at the touchdown of that swing.
        """
        padded = f"0{row}0"
        firsts = [i for i in range(len(row)) if padded[i : i + 2] == "01"]
        lasts = [i for i in range(1, len(row) + 1) if padded[i : i + 2] == "10"]
        starts, ends, footholds = list(edges[firsts]), list(edges[lasts]), [feet[i] for i in firsts]
        start, end = float(edges[0]), float(edges[-1])
        landing = None
        if not any(stood):
            wait = before.sample(np.array([start + SHORTLY])).until_touchdown[0, number]
            landing = start + SHORTLY + float(wait)
        after = behind.sample(np.array([end + SHORTLY]))
        joined = end
        if row[0] == "0":
            starts, ends, footholds = [edges[0], *starts], [edges[0], *ends], [feet[0], *footholds]
        if row[-1] == "0":
            landed = feet[-1]
            if not after.contact[0, number]:
                joined = end + SHORTLY + float(after.until_touchdown[0, number])
                after = behind.sample(np.array([joined + SHORTLY]))
                landed = after.feet[0, number]
            starts, ends, footholds = [*starts, joined], [*ends, joined], [*footholds, landed]
        following = joined + SHORTLY + float(after.until_touchdown[0, number])
        lands_at_once = row[0] == "1" and not stood[0]
        return cls(
            number=number,
            joined=joined,
            starts=np.array(starts),
            ends=np.array(ends),
            footholds=np.array(footholds),
            before=before,
            landing=landing,
            apex=apex,
            first_touchdown=start if lands_at_once else float([*starts[1:], following][0]),
            next_touchdown=following,
        )

    def at(self, times: Array) -> FootCourse:
        """The foot at times [n] s from the transition's start until it has joined."""
        which = np.searchsorted(self.starts, times, side="right") - 1
        contact = times < self.ends[which]
        position = self.footholds[which]
        velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
        air = np.flatnonzero(~contact & (which + 1 < len(self.starts)))
        if air.size:
            own = which[air]
            position[air], velocity[air], acceleration[air] = self._swings(own, times[air])
        landings = np.append(self.starts[1:], self.next_touchdown)
        return FootCourse(contact, position, velocity, acceleration, landings[which] - times)

    @property
    def stances(self) -> list[Stance]:
        """Those from the transition's start until the leg has joined."""
        each = zip(self.starts.tolist(), self.ends.tolist(), self.footholds, strict=True)
        return [Stance(start, end, foothold) for start, end, foothold in each if end > start]

    def _swings(self, own: Numbers, times: Array) -> tuple[Array, Array, Array]:
        """In the swings after stances `own` [n]."""
        lifted, landed = self.footholds[own], self.footholds[own + 1]
        since, duration = self.ends[own], self.starts[own + 1] - self.ends[own]
        x = np.clip((times - since) / duration, 0.0, 1.0)
        curve = swing(paired(lifted), paired(landed), duration, x, self.apex)
        found = [unpaired(each, lifted.shape[1]) for each in curve]
        begun = np.flatnonzero(own == 0)
        if self.landing is not None and begun.size:
            redirected = self._redirected(times[begun], self.landing, landed[begun], duration[begun], x[begun])
            for every, part in zip(found, redirected, strict=True):
                every[begun] = part
        return found[0], found[1], found[2]

    def _redirected(
        self, times: Array, landing: float, landed: Array, duration: Array, x: Array
    ) -> tuple[Array, Array, Array]:
        """A swing on its way to one foothold [n, d], led to another one by a blend with a hop on the spot there.

        Both are above the ground, and so is every mean of them. At its start the blend is the first one, at its end the
        other one, to the acceleration.
        """
        seen = self.before.sample(np.minimum(times, landing))
        old = [each[:, self.number] for each in (seen.feet, seen.foot_velocities, seen.foot_accelerations)]
        place = paired(landed)
        new = [unpaired(each, landed.shape[1]) for each in swing(place, place, duration, x, self.apex)]
        share, pace, gain = (each[:, None] for each in minimum_jerk(x))
        pace, gain = pace / duration[:, None], gain / duration[:, None] ** 2
        gap = [after - before for before, after in zip(old, new, strict=True)]
        return (
            old[0] + share * gap[0],
            old[1] + share * gap[1] + pace * gap[0],
            old[2] + share * gap[2] + 2 * pace * gap[1] + gain * gap[0],
        )
