"""A task descriptor kappa of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Split = Literal["grid", "held_out"]


@dataclass(frozen=True, order=True)
class Task:
    """Forward speed v [m/s] and cycle duration T [s], and what the task is for: the training grid or held out."""

    speed: float
    cycle_duration: float
    split: Split = "grid"
