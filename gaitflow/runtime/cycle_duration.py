"""The cycle duration that costs least, for whoever says how fast the robot should go and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from gaitflow.core.domain import Domain
from gaitflow.runtime.atlas import SUPPORT, Atlas

AXIS = "cycle_duration"
POINTS = 8  # looked at in each step of the map's grid
NARROWINGS = 25  # of the best one's surroundings, each by 0.62


@dataclass(frozen=True)
class ChosenDuration:
    """The cycle duration [s] that the map chose, with its predicted cost.

    cost_per_second is the cost of a cycle over its duration, in the scenario's units; cost_per_metre that over the
    commanded way, infinite at rest: at a given speed the same duration has the least of both. on_edge: it is the
    shortest or longest that the map allows there, so a still better one may lie beyond.
    """

    value: float
    cost_per_second: float
    cost_per_metre: float
    on_edge: bool


def cheapest_duration(
    atlas: Atlas, domain: Domain, task: Mapping[str, float], scale: float, gait: int | None = None
) -> ChosenDuration | None:
    """Of the durations that the domain allows a task the one of least cost a second, by the best gait or a given one.

    `task` has values on all other axes; `scale` times the atlas' cost is the scenario's. None where the domain allows
    no duration, or the atlas believes no cost.
    """

    rate = _rate(atlas, task, gait)
    found = [(*_least(rate, low, high, steps), low, high) for low, high, steps in _allowed(domain, task)]
    if not found:
        return None
    least, value, low, high = min(found)
    return _chosen(task, value, least * scale, value in (low, high)) if math.isfinite(least) else None


def same_duration(
    atlas: Atlas, domain: Domain, task: Mapping[str, float], scale: float, gait: int, value: float
) -> ChosenDuration | None:
    """A cycle duration [s] that was chosen for another task, for a gait; None outside the domain or without a cost."""
    if not domain.contains({**task, AXIS: value}):
        return None
    least = _rate(atlas, task, gait)(value)
    on_edge = any(value in (low, high) for low, high, _ in _allowed(domain, task))
    return _chosen(task, value, least * scale, on_edge) if math.isfinite(least) else None


def _rate(atlas: Atlas, task: Mapping[str, float], gait: int | None) -> Callable[[float], float]:
    """The believed cost a second, the problem's, by duration: of the best gait or a given one, infinite without any."""
    own = np.array([gait in (None, sheet.gait) for sheet in atlas.sheets], dtype=bool)

    def rate(duration: float) -> float:
        place = np.array([duration if axis == AXIS else task[axis] for axis in atlas.axes])
        costs, support = atlas.costs(place)
        return float(costs[own & (support >= SUPPORT)].min(initial=math.inf)) / duration

    return rate


def _chosen(task: Mapping[str, float], value: float, per_second: float, on_edge: bool) -> ChosenDuration:
    pace = math.hypot(task["speed"], task.get("lateral_speed", 0.0))
    return ChosenDuration(value, per_second, per_second / pace if pace else math.inf, on_edge)


def _allowed(domain: Domain, task: Mapping[str, float]) -> list[tuple[float, float, int]]:
    """Intervals of durations inside the domain: both ends and how many steps of the grid lie between them."""
    grid = domain.axes[AXIS]
    found: list[tuple[float, float, int]] = []
    for i, value in enumerate(grid):
        if not domain.contains({**task, AXIS: value}):
            continue
        joined = i > 0 and domain.contains({**task, AXIS: (grid[i - 1] + value) / 2})
        if joined:
            low, _, steps = found.pop()
            found.append((low, value, steps + 1))
        else:
            found.append((value, value, 0))
    return found


def _least(rate: Callable[[float], float], low: float, high: float, steps: int) -> tuple[float, float]:
    """The least rate from `low` to `high` and where it is; ends are met exactly."""
    places = np.linspace(low, high, POINTS * steps + 1).tolist()
    rates = [rate(place) for place in places]
    best = int(np.argmin(rates))
    a, b = places[max(best - 1, 0)], places[min(best + 1, len(places) - 1)]
    shrink = (math.sqrt(5) - 1) / 2
    known = [(rates[best], places[best])]
    if b <= a:
        return known[0]
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
