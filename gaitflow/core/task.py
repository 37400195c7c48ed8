"""A task kappa of the paper (section III.A): a point in named axes.

The command is a planar twist (speed, lateral_speed, yaw_rate) held for one cycle. The other axes say what else the
operator or the place decides: how long a cycle takes, how much faster the body is after it, and the ground.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gaitflow.core.trajectory import Array

# What a task is for. grid, sampled: a map is made from it, at a place of the grid or wherever it was chosen. held_out:
# nothing is learnt from it.
Split = Literal["grid", "sampled", "held_out"]
SPLITS: tuple[Split, ...] = ("grid", "sampled", "held_out")


@dataclass(frozen=True)
class Axis:
    """One number of a task: its unit, the values that are physical, and the one it has when nobody gives any.

    spatial: needs a robot with dimension 3. mirrored: changes its sign in a left-right mirror image. reversed: changes
    its sign when time runs backwards and front and hind are swapped, left and right staying, so that it goes forwards.
    commanded: an operator decides it, and not the place or the load.
    """

    name: str
    unit: str
    low: float
    high: float
    default: float | None
    meaning: str
    spatial: bool = False
    mirrored: bool = False
    reversed: bool = False
    commanded: bool = True

    def admits(self, value: float) -> bool:
        """Whether a value is a finite number from `low` to `high`."""
        return math.isfinite(value) and self.low <= value <= self.high

    def written(self, value: float) -> str:
        """A value with its unit for a reader: "0.9 m/s", and "0.8" where there is no unit."""
        return f"{value:g}" if self.unit == "1" else f"{value:g} {self.unit}"


# In the order of the task's parameters in every problem.
AXES: dict[str, Axis] = {
    axis.name: axis
    for axis in (
        Axis("speed", "m/s", -20.0, 20.0, 0.0, "forward speed v, the mean over a cycle"),
        Axis("lateral_speed", "m/s", -10.0, 10.0, 0.0, "speed to the left", spatial=True, mirrored=True, reversed=True),
        Axis("yaw_rate", "rad/s", -10.0, 10.0, 0.0, "turning rate, to the left", spatial=True, mirrored=True),
        Axis("acceleration", "m/s^2", -20.0, 20.0, 0.0, "gain of forward speed over a cycle, over T", reversed=True),
        Axis("cycle_duration", "s", 0.01, 20.0, None, "duration T of a cycle"),
        Axis(
            "slope",
            "deg",
            -59.0,
            59.0,
            0.0,
            "inclination gamma of the ground, uphill positive",
            reversed=True,
            commanded=False,
        ),
        Axis("friction", "1", 0.01, 5.0, 0.8, "friction coefficient mu", commanded=False),
        Axis("payload", "kg", 0.0, 1e4, 0.0, "mass carried, at the centre of mass", commanded=False),
    )
}
AXIS_NAMES = tuple(AXES)


@dataclass(frozen=True, order=True)
class Task:
    """A value for every axis, in the order of AXES, and what the task is for.

    Build it with `Task.of`.
    """

    values: tuple[float, ...]
    split: Split = "grid"

    @classmethod
    def of(cls, values: Mapping[str, float], split: Split = "grid") -> Task:
        """The task with these values and the defaults of all other axes.

        Raises ValueError for an axis that does not exist, that is missing and has no default, or that is out of range.
        """
        for name in values:
            if name not in AXES:
                raise ValueError(f"axis {str(name)[:80]!r} is unknown; the axes are {', '.join(AXES)}")
        chosen = {name: values.get(name, axis.default) for name, axis in AXES.items()}
        for name, value in chosen.items():
            if value is None:
                raise ValueError(f"a task needs a {name} [{AXES[name].unit}]")
            if not AXES[name].admits(value):
                raise ValueError(f"{name} = {AXES[name].written(value)}: must lie in {span(name)}")
        return cls(tuple(float(value) for value in chosen.values() if value is not None), split)

    def __getitem__(self, axis: str) -> float:
        return self.values[AXIS_NAMES.index(axis)]

    @property
    def speed(self) -> float:
        """v [m/s]."""
        return self["speed"]

    @property
    def cycle_duration(self) -> float:
        """T [s]."""
        return self["cycle_duration"]

    @property
    def parameters(self) -> Array:
        """The values [axes] as an array, in the register's units: what the problem takes."""
        return np.array(self.values)

    def on(self, axes: Iterable[str]) -> tuple[float, ...]:
        """The values on some of the axes."""
        return tuple(self[axis] for axis in axes)

    def replaced(self, **values: float) -> Task:
        """The task with other values on some axes."""
        return Task.of(dict(zip(AXIS_NAMES, self.values, strict=True)) | values, self.split)

    def mirrored(self) -> Task:
        """The task of the left-right mirror image."""
        return self._signed([axis.mirrored for axis in AXES.values()])

    def time_reversed(self) -> Task:
        """The task of the motion run backwards with front and hind swapped: forward speed stays forward."""
        return self._signed([axis.reversed for axis in AXES.values()])

    def _signed(self, flips: Sequence[bool]) -> Task:
        # Adding 0 turns -0 into 0: equal tasks have equal bytes.
        return Task(tuple((-x if flip else x) + 0.0 for flip, x in zip(flips, self.values, strict=True)), self.split)

    def text(self, axes: Iterable[str] = ("speed", "cycle_duration")) -> str:
        """The values on some axes for a reader: "speed 0.9 m/s, cycle_duration 0.6 s"."""
        return ", ".join(f"{axis} {AXES[axis].written(self[axis])}" for axis in axes)


def span(axis: str) -> str:
    """The physical range of an axis for a reader: "-20 to 20 m/s"."""
    return f"{AXES[axis].low:g} to {AXES[axis].written(AXES[axis].high)}"
