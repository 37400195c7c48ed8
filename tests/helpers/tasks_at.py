"""Tasks in one line."""

from __future__ import annotations

from gaitflow.core.task import Split, Task


def at(speed: float, cycle_duration: float, split: Split = "grid", **others: float) -> Task:
    """The task at v [m/s], T [s] and values on other axes."""
    return Task.of({"speed": speed, "cycle_duration": cycle_duration} | others, split)
