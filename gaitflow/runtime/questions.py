"""The tasks that a map is asked for: every value a finite number, every axis one that the map has."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gaitflow.core.task import AXES
from gaitflow.core.task_space import MAIN_AXES, TaskSpace
from gaitflow.core.trajectory import Array


class Questions:
    """Reads the arguments of `GaitMap`'s methods, for the tasks of one map."""

    def __init__(self, space: TaskSpace) -> None:
        self._space = space
        self._ranged = frozenset(space.ranged)
        fixed = dict(space.fixed)
        self._held = {
            axis: fixed.get(axis, AXES[axis].default or 0.0) for axis in MAIN_AXES if axis not in self._ranged
        }

    @staticmethod
    def given(speed: object, cycle_duration: object, axes: Mapping[str, Any]) -> dict[str, float]:
        """The arguments of one question by axis. Raises ValueError for a value that is no finite number."""
        return {axis: _finite(axis, value) for axis, value in _named(speed, cycle_duration, axes).items()}

    def one(self, given: Mapping[str, float]) -> dict[str, float]:
        """Values by axis of one task: speed, cycle_duration and the other ranged axes.

        Raises ValueError for an axis that is not there, that is missing, or that is held at another value.
        """
        if given.keys() != self._ranged:
            self._check_axes(given)
        return {axis: given.get(axis, self._held.get(axis, 0.0)) for axis in self._space.columns}

    def many(
        self, speed: ArrayLike | None, cycle_duration: ArrayLike | None, axes: Mapping[str, ArrayLike]
    ) -> dict[str, Array]:
        """Arrays of one shape by axis, as `one`. Raises ValueError also for shapes that do not broadcast."""
        given = {axis: _all_finite(axis, values) for axis, values in _named(speed, cycle_duration, axes).items()}
        if given.keys() != self._ranged:
            for pick in (np.min, np.max):  # an axis that is held has its one value when both of these have
                self._check_axes({axis: float(pick(values)) for axis, values in given.items() if values.size})
        columns = np.broadcast_arrays(*(given[axis] for axis in given))
        by_axis = dict(zip(given, columns, strict=True))
        return {axis: by_axis[axis] for axis in self._space.ranged}

    @staticmethod
    def physical(task: Mapping[str, float]) -> bool:
        """Whether every value lies in its axis' physical range."""
        return all(AXES[axis].admits(value) for axis, value in task.items())

    def _check_axes(self, given: Mapping[str, float]) -> None:
        """Refuse axes that are not the map's, whatever the values on those that are."""
        admitted = {axis: AXES[axis].high for axis in self._ranged}
        self._space.task({axis: admitted.get(axis, value) for axis, value in given.items()})


def _named(speed: Any, cycle_duration: Any, axes: Mapping[str, Any]) -> dict[str, Any]:
    values = {"speed": speed, "cycle_duration": cycle_duration}
    return {axis: value for axis, value in values.items() if value is not None} | dict(axes)


def _finite(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name} = {value!r}: must be a finite number")
    try:
        number = float(value)
    except OverflowError:  # an integer beyond every float
        number = math.inf
    if not math.isfinite(number):
        raise ValueError(f"{name} = {number}: must be a finite number")
    return number


def _all_finite(name: str, values: ArrayLike) -> Array:
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: must hold finite numbers, found {array.dtype}")
    numbers = array.astype(np.float64)
    if not np.isfinite(numbers).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(numbers))[0])
        raise ValueError(f"{name}{list(where)} = {numbers[where]}: must be a finite number")
    return numbers
