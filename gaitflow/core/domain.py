"""The tasks that a map answers for: where its grid was solved with success."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array

# Grid values are rounded to 1e-9 when a scenario is read; a query this close to one is that one.
SNAP = 1e-9


class AxisValues(Protocol):
    """A task's values by axis: a mapping, or a `Task`."""

    def __getitem__(self, axis: str, /) -> float: ...


@dataclass(frozen=True, eq=False)
class Domain:
    """A grid of tasks: for every ranged axis its rising values, in the order of AXES, and which tasks are feasible.

    `feasible` has one dimension an axis. A task is inside when every grid task that surrounds it has a feasible gait:
    the corners of its cell, the ends of its grid line, or the one grid task it coincides with. Nothing beyond the
    outermost grid tasks is inside. Raises ValueError for axes that are unknown or do not rise, or another shape.
    """

    axes: Mapping[str, tuple[float, ...]]
    feasible: NDArray[np.bool_]

    def __post_init__(self) -> None:
        for axis, values in self.axes.items():
            if axis not in AXES or not values or any(b <= a for a, b in pairwise(values)):
                raise ValueError(f"domain.{axis}: must be one of {', '.join(AXES)}, with rising values")
        shape = tuple(map(len, self.axes.values()))
        if not shape or self.feasible.shape != shape or self.feasible.dtype != np.bool_:
            raise ValueError(f"domain: feasible is {self.feasible.dtype} {self.feasible.shape}; expected bool {shape}")

    def contains(self, task: AxisValues) -> bool:
        """Whether one finite task is inside; it may have values on other axes, too, which are not looked at."""
        around = []
        for axis, values in self.axes.items():
            first, last = _around(values, task[axis])
            if first < 0 or last == len(values):
                return False
            around.append(slice(min(first, last), max(first, last) + 1))
        return bool(self.feasible[tuple(around)].all())

    def contains_many(self, tasks: Mapping[str, Array]) -> NDArray[np.bool_]:
        """`contains` for arrays of one shape, one for every axis."""
        around = []
        inside = np.ones(np.broadcast_shapes(*(np.shape(tasks[axis]) for axis in self.axes)), dtype=bool)
        for axis, values in self.axes.items():
            first = np.searchsorted(values, tasks[axis] + SNAP, side="right") - 1
            last = np.searchsorted(values, tasks[axis] - SNAP, side="left")
            inside &= (first >= 0) & (last < len(values))
            around.append((first, last))
        for corner in product((0, 1), repeat=len(around)):
            places = (np.where(inside, ends[side], 0) for ends, side in zip(around, corner, strict=True))
            inside &= self.feasible[tuple(places)]
        return inside

    def explain(self, task: AxisValues) -> str:
        """Why a task is not inside: axis, value and range, or the surrounding tasks without a feasible gait."""
        around = []
        for axis, values in self.axes.items():
            first, last = _around(values, task[axis])
            if first < 0 or last == len(values):
                low, value, high = (_text(axis, x) for x in (values[0], task[axis], values[-1]))
                return f"{axis} = {value} is outside the map's {low} to {high}"
            around.append(sorted({first, last}))
        without = [places for places in product(*around) if not self.feasible[places]]
        grid = tuple(self.axes.values())
        tasks = (self._task_text([values[i] for values, i in zip(grid, places, strict=True)]) for places in without)
        asked = self._task_text([task[axis] for axis in self.axes])
        return f"task {asked} lies at grid tasks without a feasible gait: {', '.join(tasks)}"

    def distance(self, task: AxisValues) -> float:
        """From a task to the nearest grid task with a feasible gait, in steps of the grid; infinite without any."""
        if not len(self._trained):
            return float("inf")
        with np.errstate(over="ignore"):  # further than a float reaches is infinitely far
            away = (self._trained - [task[axis] for axis in self.axes]) / self.steps
            return float(np.hypot.reduce(away, axis=1).min())

    @cached_property
    def steps(self) -> Array:
        """Mean step of every axis [a] in its unit; 1 for an axis of one value."""
        return np.array([(v[-1] - v[0]) / (len(v) - 1) if len(v) > 1 else 1.0 for v in self.axes.values()])

    @property
    def middle(self) -> dict[str, float]:
        """The grid task with a feasible gait nearest to the middle of all axes. Raises ValueError without any."""
        if not len(self._trained):
            raise ValueError("the domain has no task with a feasible gait")
        ends = np.array([(values[0], values[-1]) for values in self.axes.values()])
        away = np.linalg.norm((self._trained - ends.mean(axis=1)) / self.steps, axis=1)
        return dict(zip(self.axes, self._trained[away.argmin()].tolist(), strict=True))

    @cached_property
    def _trained(self) -> Array:
        """Grid tasks with a feasible gait [n, a]."""
        places = np.nonzero(self.feasible)
        return np.column_stack([np.array(v)[index] for v, index in zip(self.axes.values(), places, strict=True)])

    def _task_text(self, values: Sequence[float]) -> str:
        return f"({', '.join(_text(axis, value) for axis, value in zip(self.axes, values, strict=True))})"


def _text(axis: str, value: float) -> str:
    unit = AXES[axis].unit
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"


def _around(values: tuple[float, ...], value: float) -> tuple[int, int]:
    """Indices of the last grid value at or below `value` and the first at or above; -1 and len(values) are beyond."""
    return bisect_right(values, value + SNAP) - 1, bisect_left(values, value - SNAP)
