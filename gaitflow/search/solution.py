"""What one solve gives: a trajectory with its cost and our own verdict, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gaitflow.core.trajectory import Trajectory
from gaitflow.solvers.point import Multipliers

__all__ = ["Multipliers", "Solution", "Status"]

# solved: our check found it feasible. infeasible: no start led to a feasible point. failed: limit, exception or
# crash of the solver. screened: a necessary condition rules the pattern out, nothing was solved. probed: solved on a
# coarse mesh only, where it was far from the best.
Status = Literal["solved", "infeasible", "failed", "screened", "probed"]


@dataclass(frozen=True)
class Solution:
    """One row of the dataset."""

    speed: float  # m/s
    cycle_duration: float  # s
    split: Literal["grid", "held_out"]
    pattern: str  # as solved, legs' rows of all phases joined by "/": "0110/1100"
    gait: str  # canonical: equal neighbours merged, rotated, mirrored
    strategy: str
    start: str  # where the kept solve began: "neighbour", "nominal", "random-3", ...
    seed: int
    status: Status
    solver_status: str
    cost: float  # unscaled, NaN when there is no trajectory
    violation: float  # worst scaled constraint violation found by gaitflow.core.check, NaN without trajectory
    iterations: int  # over all starts of this row
    solves: int  # solver calls of this row
    wall_s: float
    cpu_s: float
    trajectory: Trajectory | None = None
    multipliers: Multipliers | None = None
