"""When a leg stands and where: the contact schedule of one leg, repeated over all cycles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.motion.cycles import Cycles, Numbers, Pair, Places

SHORTLY = 1e-9  # s: nearer instants are one


class Stance(NamedTuple):
    """A foot on the ground from `start` to `end` [s], at `foothold` [d] m."""

    start: float
    end: float
    foothold: Array


@dataclass(frozen=True, eq=False)
class Stances:
    """The stances of a leg that begin within one cycle: start and end [s] s, rising, and footholds [s, 2] m.

    An end may lie in the next cycle. A leg that never stands has no stance. One that always stands has one, which lasts
    the cycle and which `always` tells from one that begins anew.
    """

    start: Array
    end: Array
    footholds: Pair
    always: bool

    @classmethod
    def of(cls, row: str, times: Array, feet: Pair, steps_per_phase: int) -> Stances:
        """The stances of a pattern's row, on knots at `times` [K + 1] s with the foot at `feet` [K + 1, 2] m."""
        edges = times[::steps_per_phase]
        phases, period = len(row), float(times[-1])
        if "0" not in row:
            return cls(np.zeros(1), np.array([period]), feet[:1], always=True)
        touchdowns = [i for i in range(phases) if row[i - 1] == "0" and row[i] == "1"]
        lift_offs = [next(i for i in range(start, start + phases) if row[i % phases] == "0") for start in touchdowns]
        return cls(
            start=edges[touchdowns],
            end=edges[[i % phases for i in lift_offs]] + [period if i >= phases else 0.0 for i in lift_offs],
            footholds=feet[[i * steps_per_phase for i in touchdowns]],
            always=False,
        )

    def last(self, numbers: Numbers, since: Array) -> tuple[Numbers, Numbers]:
        """The stance that began last at times `since` [n] s of cycles [n]: its place among the stances, its cycle."""
        which = np.searchsorted(self.start, since, side="right") - 1
        return which % len(self.start), numbers - (which < 0)

    def following(self, which: Numbers, numbers: Numbers) -> tuple[Numbers, Numbers]:
        """The stance after each one of those."""
        return (which + 1) % len(self.start), numbers + (which + 1 == len(self.start))

    def placed(self, which: Numbers, numbers: Numbers, places: Places, cycles: Cycles) -> Pair:
        """Footholds [n, 2] m in the world of stances `which` [n] of cycles `numbers` [n].

        While the body gains speed from cycle to cycle, it passes the middle of each stance where it does in the plan:
        the foothold is as much further as the body is then. But the stances of the plan itself, and those before and
        after them, to which its swings lead, stay where it has them.
        """
        origin, turn, drift = places.of(numbers)
        footholds: Pair = origin + turn * self.footholds[which]
        if not cycles.gain.any():
            return footholds
        period = cycles.period
        middle = ((self.start + self.end) / 2)[which]
        middle = np.where((numbers == 0) | ((numbers == 1) & (which == 0)), 0.0, middle)
        middle = np.where((numbers == -1) & (which == len(self.start) - 1), period, middle)[:, None]
        _, _, after = places.of(numbers + 1)
        further: Pair = drift * np.minimum(middle, period) + after * np.maximum(middle - period, 0.0)
        return footholds + further

    def during(self, start: float, stop: float, cycles: Cycles) -> Iterator[tuple[float, float, Pair]]:
        """Start, end and foothold [2] of each stance that reaches into the time from `start` to `stop` [s]."""
        if self.always:
            yield -np.inf, np.inf, self.footholds[0]
            return
        first, behind = math.floor(start / cycles.period) - 1, math.ceil(stop / cycles.period)
        numbers = np.repeat(np.arange(first, behind), len(self.start))
        which = np.tile(np.arange(len(self.start)), behind - first)
        starts, ends = (each[which] + numbers * cycles.period for each in (self.start, self.end))
        reaching = (starts < stop) & (ends > start)
        placed = self.placed(which, numbers, cycles.places(numbers), cycles)
        yield from zip(starts[reaching].tolist(), ends[reaching].tolist(), placed[reaching], strict=True)


def within(stances: Iterable[Stance], start: float, stop: float) -> list[Stance]:
    """What of stances is from `start` to `stop` [s]."""
    cut = (Stance(max(begin, start), min(end, stop), foothold) for begin, end, foothold in stances)
    return [stance for stance in cut if stance.end - stance.start > SHORTLY]


def connected(stances: Iterable[Stance]) -> list[Stance]:
    """Stances in order, of which those without a swing in between are one."""
    found: list[Stance] = []
    for stance in stances:
        if found and stance.start - found[-1].end <= SHORTLY:
            found[-1] = found[-1]._replace(end=stance.end)
        else:
            found.append(stance)
    return found
