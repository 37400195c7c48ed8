"""A map over any axes as pictures of two: a panel a slice, at the grid's values of all axes but the two main ones."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gaitflow.config.axes import Tasks
from gaitflow.core.task_space import MAIN_AXES, TaskSpace
from gaitflow.report.map_tasks import on_grid

MAX_PANELS = 9
SAME = 1e-9  # grid values are rounded to it


@dataclass(frozen=True)
class Slice:
    """One value of every further axis, and the rows of the labels whose tasks are drawn there."""

    at: dict[str, float]
    labels: pd.DataFrame


@dataclass(frozen=True)
class Slices:
    """The panels of a map, with what is on their axes; y is None for a map with one axis.

    `limits` are the lowest and the highest value of x and, if there is one, of y. `further` has the values that are
    drawn of the further axes, `panels` a panel for each of their combinations, the last axis fastest. `count` is how
    many slices there are to choose from, `between` how many held-out tasks lie between them, in none; `nearest` is
    whether each task is drawn in the slice nearest to it, as those that were chosen off the grid are.
    """

    x: str
    y: str | None
    limits: dict[str, tuple[float, float]]
    further: dict[str, tuple[float, ...]]
    panels: tuple[Slice, ...]
    count: int
    between: int
    nearest: bool

    @property
    def remark(self) -> str:
        """What a reader must know of what is not drawn, or elsewhere than it lies; "" when all is in its place."""
        parts = []
        if len(self.panels) < self.count:
            parts.append(f"{len(self.panels)} of {self.count} slices of the map are drawn, evenly chosen.")
        if self.between:
            parts.append(f"{self.between} held-out tasks lie between the slices and are not drawn.")
        if self.nearest:
            parts.append("Each task is drawn in the slice nearest to it.")
        return " ".join(parts)


@dataclass(frozen=True)
class Nearest:
    """Of each row of the labels the slice nearest to its task, and whether the task lies beside it, not in it."""

    place: NDArray[np.int64]
    beside: NDArray[np.bool_]


def main_axes(space: TaskSpace) -> tuple[str, str | None]:
    """Speed and cycle duration where both have a range, otherwise the first two axes with one, or the only one."""
    first, *others = MAIN_AXES if set(MAIN_AXES) <= set(space.ranged) else space.ranged
    return first, others[0] if others else None


def nearest_slices(labels: pd.DataFrame, further: dict[str, tuple[float, ...]]) -> Nearest:
    """The nearest slice of each task, numbered with the last of the further axes fastest.

    Nearest on every axis, so on a grid with even steps within half a step.
    """
    place, beside = np.zeros(len(labels), dtype=np.int64), np.zeros(len(labels), dtype=bool)
    for axis, values in further.items():
        away = np.abs(labels[axis].to_numpy(dtype=float)[:, None] - np.array(values))
        nearest = away.argmin(axis=1)
        place = place * len(values) + nearest
        beside |= away[np.arange(len(labels)), nearest] > SAME
    return Nearest(place, beside)


def slices_of(labels: pd.DataFrame, tasks: Tasks, most: int = MAX_PANELS) -> Slices:
    """The panels of a labels frame at the values of the scenario's grid; at most `most`, the outermost kept.

    Raises ValueError when there is no task.
    """
    if labels.empty:
        raise ValueError("the labels have no task; solve the scenario first")
    x, y = main_axes(tasks.space)
    grid = {axis: values.values for axis, values in tasks.ranges.items()}
    limits = {axis: (grid[axis][0], grid[axis][-1]) for axis in (x, y) if axis is not None}
    values = {axis: each for axis, each in grid.items() if axis not in limits}
    count = math.prod(map(len, values.values()))
    numbers = _evenly([len(each) for each in values.values()], most)
    chosen = [_outermost(len(each), number) for each, number in zip(values.values(), numbers, strict=True)]
    further = {axis: tuple(values[axis][i] for i in kept) for axis, kept in zip(values, chosen, strict=True)}
    found = nearest_slices(labels, values)
    scattered = not on_grid(labels)
    drawn = ~found.beside | scattered
    shape = tuple(map(len, values.values()))
    panels = []
    for place in product(*chosen):
        here = found.place == (np.ravel_multi_index(place, shape) if place else 0)
        at = {axis: values[axis][i] for axis, i in zip(values, place, strict=True)}
        panels.append(Slice(at, labels[here & drawn]))
    return Slices(x, y, limits, further, tuple(panels), count, int((~drawn).sum()), scattered and bool(values))


def _evenly(counts: list[int], most: int) -> list[int]:
    """Of how many values of each axis panels are drawn, so that there are at most `most` and the axes share them."""
    numbers = [1] * len(counts)
    while True:
        panels = math.prod(numbers)
        more = [i for i, own in enumerate(numbers) if own < counts[i] and panels // own * (own + 1) <= most]
        if not more:
            return numbers
        numbers[min(more, key=lambda i: numbers[i])] += 1


def _outermost(count: int, number: int) -> list[int]:
    """`number` places of `count`, evenly spread, the first and the last among them; the middle one when it is one."""
    if number == 1:
        return [count // 2]
    return [int(place) for place in np.linspace(0, count - 1, number).round()]
