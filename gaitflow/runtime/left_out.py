"""The value of least cost on an axis that is left out of a task, such as the cycle duration for a given speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitflow.core.domain import Domain
from gaitflow.core.task import AXES
from gaitflow.runtime.atlas import SUPPORT, Atlas

Per = Literal["second", "metre"]
Rates = Callable[[Sequence[float]], list[float]]  # costs a second or a metre of values
POINTS = 8  # looked at in each step of the map's grid
NARROWINGS = 25  # of the best one's surroundings, each by 0.62


@dataclass(frozen=True)
class ChosenValue:
    """The value that the map chose on an axis, in the axis' unit, with its predicted cost.

    cost_per_second is the cost of a cycle over its duration, in the scenario's units; cost_per_metre that over the
    commanded way, infinite at rest. on_edge: it is the least or the largest that the map allows there, so a still
    better one may lie beyond.
    """

    axis: str
    value: float
    cost_per_second: float
    cost_per_metre: float
    on_edge: bool

    def rate(self, per: Per) -> float:
        """The cost a second or a metre."""
        return self.cost_per_second if per == "second" else self.cost_per_metre


@dataclass(frozen=True)
class Chooser:
    """Chooses a value on one axis of a map, by cost `per` second or metre.

    `scale` times the atlas' cost is the scenario's cost. At a given speed, the same cycle duration costs least per
    second and per metre. If the speed is left out, the least cost per second is at a slow speed, and the least cost per
    metre at the speed at which a distance costs least.
    """

    atlas: Atlas
    domain: Domain
    scale: float
    axis: str
    per: Per

    def cheapest(self, task: Mapping[str, float], gait: int | None = None) -> ChosenValue | None:
        """Of the values that the domain allows the one of least cost, by the best gait or a given one.

        `task` has values on all other axes. None where the domain allows no value, or the atlas believes no cost.
        """
        rates = self._rates(task, gait)
        found = [(*_least(rates, low, high, steps), low, high) for low, high, steps in self._allowed(task)]
        if not found:
            return None
        least, value, low, high = min(found)
        return self._chosen(task, value, least, value in (low, high))

    def same(self, task: Mapping[str, float], gait: int, value: float) -> ChosenValue | None:
        """A value that was chosen for another task, for a gait; None outside the domain or without a cost."""
        if not self.domain.contains({**task, self.axis: value}):
            return None
        on_edge = any(value in (low, high) for low, high, _ in self._allowed(task))
        return self._chosen(task, value, self._rates(task, gait)([value])[0], on_edge)

    def _rates(self, task: Mapping[str, float], gait: int | None) -> Rates:
        """The believed cost a second or a metre by value: of the best gait or a given one, infinite without any."""
        own = np.array([gait in (None, sheet.gait) for sheet in self.atlas.sheets], dtype=bool)

        def rates(values: Sequence[float]) -> list[float]:
            tasks = [{**task, self.axis: value} for value in values]
            places = np.array([[whole[axis] for axis in self.atlas.axes] for whole in tasks])
            costs, support = self.atlas.costs_of_many(places)
            least = np.where(own & (support >= SUPPORT), costs, math.inf).min(axis=1, initial=math.inf)
            overs = [whole["cycle_duration"] * (1.0 if self.per == "second" else _pace(whole)) for whole in tasks]
            return [float(cost) / over if over else math.inf for cost, over in zip(least, overs, strict=True)]

        return rates

    def _chosen(self, task: Mapping[str, float], value: float, rate: float, on_edge: bool) -> ChosenValue | None:
        """A value with its rate as the atlas counts costs; None without a cost."""
        if not math.isfinite(rate):
            return None
        pace = _pace({**task, self.axis: value})
        per_second = rate * self.scale * (1.0 if self.per == "second" else pace)
        return ChosenValue(self.axis, value, per_second, per_second / pace if pace else math.inf, on_edge)

    def _allowed(self, task: Mapping[str, float]) -> list[tuple[float, float, int]]:
        """Intervals of values inside the domain: both ends and how many steps of the grid lie between them."""
        grid = self.domain.axes[self.axis]
        found: list[tuple[float, float, int]] = []
        for i, value in enumerate(grid):
            if not self.domain.contains({**task, self.axis: value}):
                continue
            joined = i > 0 and self.domain.contains({**task, self.axis: (grid[i - 1] + value) / 2})
            if joined:
                low, _, steps = found.pop()
                found.append((low, value, steps + 1))
            else:
                found.append((value, value, 0))
        return found


def _pace(task: Mapping[str, float]) -> float:
    return math.hypot(task["speed"], task.get("lateral_speed", 0.0))


def left_out(ranged: Collection[str], given: Collection[str]) -> str | None:
    """The one axis of a map that a task leaves to it; None where nothing is, or more than one, or what no map chooses.

    A map chooses what an operator commands. How the ground is, and what is carried, it has to be told.
    """
    missing = [axis for axis in ranged if axis not in given]
    return missing[0] if len(missing) == 1 and AXES[missing[0]].commanded else None


def _least(rates: Rates, low: float, high: float, steps: int) -> tuple[float, float]:
    """The least rate from `low` to `high` and where it is; ends are met exactly."""
    places = np.linspace(low, high, POINTS * steps + 1).tolist()
    looked_at = rates(places)
    best = int(np.argmin(looked_at))
    a, b = places[max(best - 1, 0)], places[min(best + 1, len(places) - 1)]
    shrink = (math.sqrt(5) - 1) / 2
    known = [(looked_at[best], places[best])]
    if b <= a:
        return known[0]

    def rate(place: float) -> float:
        return rates([place])[0]

    left, right = ((rate(place), place) for place in (b - shrink * (b - a), a + shrink * (b - a)))
    for _ in range(NARROWINGS):
        known += [left, right]
        if left < right:
            b, right = right[1], left
            left = (rate(b - shrink * (b - a)), b - shrink * (b - a))
        else:
            a, left = left[1], right
            right = (rate(a + shrink * (b - a)), a + shrink * (b - a))
    return min(known)
