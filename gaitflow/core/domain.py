"""The tasks that a map answers for: where its grid was solved with success."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

# Grid values are rounded to 1e-9 when a scenario is read; a query this close to one is that one.
SNAP = 1e-9


@dataclass(frozen=True)
class Domain:
    """A grid of tasks: rising speeds [m/s], rising cycle durations [s], feasible [speeds][cycle durations].

    A task is inside when every grid task that surrounds it has a feasible gait: the four corners of its cell, the two
    ends of its grid line, or the one grid task it coincides with. Nothing beyond the outermost grid tasks is inside.
    """

    speeds: tuple[float, ...]
    cycle_durations: tuple[float, ...]
    feasible: tuple[tuple[bool, ...], ...]

    def contains(self, speed: float, cycle_duration: float) -> bool:
        """Whether one finite task is inside."""
        i, k = _around(self.speeds, speed)
        j, m = _around(self.cycle_durations, cycle_duration)
        if i < 0 or j < 0 or k == len(self.speeds) or m == len(self.cycle_durations):
            return False
        low, high = self.feasible[i], self.feasible[k]
        return low[j] and low[m] and high[j] and high[m]

    def contains_many(self, speeds: NDArray[np.float64], cycle_durations: NDArray[np.float64]) -> NDArray[np.bool_]:
        """`contains` for arrays of one shape."""
        i, k = _around_many(self.speeds, speeds)
        j, m = _around_many(self.cycle_durations, cycle_durations)
        inside = (i >= 0) & (j >= 0) & (k < len(self.speeds)) & (m < len(self.cycle_durations))
        i, k, j, m = (np.where(inside, index, 0) for index in (i, k, j, m))
        grid = self._grid
        result: NDArray[np.bool_] = inside & grid[i, j] & grid[i, m] & grid[k, j] & grid[k, m]
        return result

    def explain(self, speed: float, cycle_duration: float) -> str:
        """Why a task is not inside: the value and the range, or the surrounding tasks without a feasible gait."""
        for name, value, axis, unit in (
            ("speed", speed, self.speeds, "m/s"),
            ("cycle_duration", cycle_duration, self.cycle_durations, "s"),
        ):
            first, last = _around(axis, value)
            if first < 0 or last == len(axis):
                return f"{name} = {value:g} {unit} is outside the map's {axis[0]:g} to {axis[-1]:g} {unit}"
        corners = {
            (self.speeds[i], self.cycle_durations[j])
            for i in _around(self.speeds, speed)
            for j in _around(self.cycle_durations, cycle_duration)
            if not self.feasible[i][j]
        }
        tasks = ", ".join(f"({v:g} m/s, {t:g} s)" for v, t in sorted(corners))
        return f"task ({speed:g} m/s, {cycle_duration:g} s) lies at grid tasks without a feasible gait: {tasks}"

    def distance(self, speed: float, cycle_duration: float) -> float:
        """From a task to the nearest grid task with a feasible gait, in steps of the grid; infinite without any."""
        tasks, steps = self._trained
        if not len(tasks):
            return float("inf")
        with np.errstate(over="ignore"):  # further than a float reaches is infinitely far
            away = (tasks - (speed, cycle_duration)) / steps
            return float(np.hypot(away[:, 0], away[:, 1]).min())

    @cached_property
    def _trained(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Grid tasks with a feasible gait [n, 2], and the mean steps of the axes [2]; 1 for an axis of one value."""
        axes = (self.speeds, self.cycle_durations)
        rows, columns = np.nonzero(self._grid)
        tasks = np.column_stack([np.array(axis)[index] for axis, index in zip(axes, (rows, columns), strict=True)])
        steps = [(axis[-1] - axis[0]) / (len(axis) - 1) if len(axis) > 1 else 1.0 for axis in axes]
        return tasks, np.array(steps)

    @cached_property
    def _grid(self) -> NDArray[np.bool_]:
        return np.array(self.feasible, dtype=bool)


def _around(axis: tuple[float, ...], value: float) -> tuple[int, int]:
    """Indices of the last grid value at or below `value` and the first at or above; -1 and len(axis) are beyond."""
    return bisect_right(axis, value + SNAP) - 1, bisect_left(axis, value - SNAP)


def _around_many(axis: tuple[float, ...], values: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    return np.searchsorted(axis, values + SNAP, side="right") - 1, np.searchsorted(axis, values - SNAP, side="left")
