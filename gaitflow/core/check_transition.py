"""Is a motion from one state to another feasible? The check's terms, with two states in place of periodicity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gaitflow.core.check import violations
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory


def violations_between(
    scenario: Mapping[str, Any], trajectory: Trajectory, task: Task, pattern: str, states: tuple[Array, Array]
) -> dict[str, float]:
    """Worst scaled violation by kind of a motion that leads from the first to the second state [nb + legs d].

    A state is base and feet. "ends" is how far the first and the last knot are from them; everything else is as of
    `gaitflow.core.check.violations`, which raises as well.
    """
    found = violations(scenario, trajectory, task, pattern)
    if found.pop("periodicity", None) is None:  # arrays that nothing can be said of
        return found
    knots = (np.concatenate([trajectory.base[knot], trajectory.feet[knot].ravel()]) for knot in (0, -1))
    found["ends"] = max(float(np.abs(knot - state).max()) for knot, state in zip(knots, states, strict=True))
    return found
