"""Which axes of a task a scenario ranges over, and which it fixes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gaitflow.core.task import AXES, Split, Task

MAIN_AXES = ("speed", "cycle_duration")  # columns of every table, also where a scenario fixes them


@dataclass(frozen=True)
class TaskSpace:
    """The axes with a range, in the order of AXES, and the fixed values of others; the rest have their defaults."""

    ranged: tuple[str, ...]
    fixed: tuple[tuple[str, float], ...]

    @classmethod
    def of(cls, scenario: Mapping[str, Any]) -> TaskSpace:
        """The task space of a scenario's JSON data (`Scenario.as_data`)."""
        axes = scenario["tasks"]["axes"]
        ranged = tuple(axis for axis in AXES if isinstance(axes.get(axis), Mapping))
        fixed = tuple((axis, float(axes[axis])) for axis in AXES if axis in axes and axis not in ranged)
        return cls(ranged, fixed)

    @property
    def columns(self) -> tuple[str, ...]:
        """The axes that tables have a column for: speed, cycle_duration and the others with a range."""
        return (*MAIN_AXES, *(axis for axis in self.ranged if axis not in MAIN_AXES))

    def task(self, values: Mapping[str, float], split: Split = "grid") -> Task:
        """The task with these values on the ranged axes; a fixed axis may be given with the value that it has.

        Raises ValueError for an axis that is not there, that is missing, or that is fixed at another value.
        """
        fixed = dict(self.fixed)
        for axis, value in values.items():
            if axis in self.ranged:
                continue
            held = fixed.get(axis, AXES[axis].default if axis in AXES else None)
            if held is None:
                raise ValueError(f"axis {str(axis)[:80]!r} is unknown here; the axes are {', '.join(self.ranged)}")
            if value != held:
                raise ValueError(
                    f"{axis} = {value:g}: it is fixed at {AXES[axis].written(held)} here; "
                    f"the axes are {', '.join(self.ranged)}"
                )
        missing = [axis for axis in self.ranged if axis not in values]
        if missing:
            raise ValueError(f"a task here needs {', '.join(missing)} as well; the axes are {', '.join(self.ranged)}")
        return Task.of(fixed | dict(values), split)
