"""One leg of a motion: where its foot is at any time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.motion.cycles import Cycles, Numbers, Pair, Places
from gaitflow.motion.stances import Stances
from gaitflow.motion.swing import Curve, PlannedSwing, swing


@dataclass(frozen=True, eq=False)
class Foot:
    """A foot at n times: contact [n], position, velocity and acceleration [n, 2], time [n] s to its next touchdown."""

    contact: NDArray[np.bool_]
    position: Pair
    velocity: Pair
    acceleration: Pair
    until_touchdown: Array


@dataclass(frozen=True, eq=False)
class Leg:
    """The stances of a leg and the swings between them.

    times [K + 1] s and feet [K + 1, 2] m are the plan's knots, of which `planned` has those of the swing after each
    stance. apex [m] is that of swings of our own, None where the plan's are kept.
    """

    stances: Stances
    times: Array
    feet: Pair
    planned: tuple[PlannedSwing, ...]
    apex: float | None

    @classmethod
    def of(cls, row: str, times: Array, feet: Pair, steps_per_phase: int, cycles: Cycles, apex: float | None) -> Leg:
        """The leg of a pattern's row, with its foot at the knots."""
        stances = Stances.of(row, times, feet, steps_per_phase)
        planned = () if stances.always or apex is not None else _planned(stances, times, feet, cycles)
        return cls(stances, times, feet, planned, apex)

    def at(self, numbers: Numbers, since: Array, places: Places, cycles: Cycles) -> Foot:
        """The foot at times `since` [n] s of cycles `numbers` [n], which lie at `places`."""
        stances, count = self.stances, len(since)
        never = np.full(count, np.inf)
        if stances.always:
            rest, (origin, turn, _) = np.zeros((count, 2), dtype=complex), places.of(numbers)
            return Foot(np.ones(count, dtype=bool), origin + turn * self.feet[0], rest, rest, never)
        if not len(stances.start):
            return Foot(np.zeros(count, dtype=bool), *self._in_the_air(since, places.of(numbers)), never)
        which, own = stances.last(numbers, since)
        then, its = stances.following(which, own)
        passed = since + (numbers - own) * cycles.period  # in the cycle in which the stance began
        lift_off = stances.end[which]
        touchdown = stances.start[then] + (its - own) * cycles.period
        contact = passed < lift_off
        position = stances.placed(which, own, places, cycles)
        velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
        air = np.flatnonzero(~contact)
        if air.size:
            landed = stances.placed(then[air], its[air], places, cycles)
            duration = (touchdown - lift_off)[air]
            x = np.clip((passed - lift_off)[air] / duration, 0.0, 1.0)
            turn = places.of(own[air])[1]
            curve = self._swinging(which[air], position[air], landed, duration, x, turn)
            position[air], velocity[air], acceleration[air] = curve
        return Foot(contact, position, velocity, acceleration, touchdown - passed)

    def _swinging(self, which: Numbers, lifted: Pair, landed: Pair, duration: Array, x: Array, turn: Pair) -> Curve:
        if self.apex is not None:
            return swing(lifted, landed, duration, x, self.apex)
        curve: Curve = (np.zeros_like(lifted), np.zeros_like(lifted), np.zeros_like(lifted))
        for number, planned in enumerate(self.planned):
            at = which == number
            found = planned.at(lifted[at], landed[at], duration[at], x[at], turn[at])
            for every, part in zip(curve, found, strict=True):
                every[at] = part
        return curve

    def _in_the_air(self, since: Array, place: Pair) -> Curve:
        """Of a leg that never stands: as planned, in straight lines between knots, as much faster as the body is."""
        origin, turn, drift = place
        step = np.searchsorted(self.times[1:-1], since, side="right")
        h = np.diff(self.times)[:, None]
        speed = (np.diff(self.feet, axis=0) / h)[step]
        s = since[:, None]
        planned = self.feet[step] + speed * (s - self.times[step][:, None])
        return (
            origin + turn * planned + drift * s,
            turn * speed + drift,
            np.zeros_like(speed),
        )


def _planned(stances: Stances, times: Array, feet: Pair, cycles: Cycles) -> tuple[PlannedSwing, ...]:
    """The plan's own swings, each in the coordinates of the cycle in which the stance before it begins."""
    unrolled_times = np.concatenate([times, times[1:] + cycles.period])
    unrolled = np.concatenate([feet, cycles.turn * feet[1:] + cycles.shift])
    touchdowns = np.append(stances.start[1:], stances.start[:1] + cycles.period)
    found = []
    for lift_off, touchdown in zip(stances.end, touchdowns, strict=True):
        first, last = (int(np.abs(unrolled_times - time).argmin()) for time in (lift_off, touchdown))
        parts = (unrolled_times[first : last + 1] - unrolled_times[first]) / (touchdown - lift_off)
        own = unrolled[first : last + 1]
        line = own[0] + parts[:, None] * (own[-1] - own[0])
        found.append(PlannedSwing(parts, own - line))
    return tuple(found)
