"""The result of one pattern at one task: a motion with its cost and our own verdict, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Trajectory
from gaitflow.solvers.point import Multipliers

# solved: our check found it feasible. infeasible: no start led to a feasible point. failed: no verdict, but for limits,
# exceptions or crashes of the solver. screened: a necessary condition rules the pattern out, nothing was solved.
# probed: solved on a coarse mesh only, where it was far from the best.
Status = Literal["solved", "infeasible", "failed", "screened", "probed"]

NAN = float("nan")


@dataclass(frozen=True)
class Solution:
    """One row of the dataset; the defaults are those of a pattern that was not solved."""

    task: Task
    pattern: str  # as solved, legs' rows of all phases joined by "/": "0110/1100"
    gait: str  # canonical: equal neighbours merged, the smallest of its rotations and images under the task's symmetry
    strategy: str
    start: str  # where the kept solve began: "neighbour", "nominal", "random-3", ...
    seed: int
    status: Status
    solver_status: str
    cost: float = NAN  # unscaled, NaN when there is no trajectory
    violation: float = NAN  # worst scaled constraint violation found by gaitflow.core.check, NaN without trajectory
    iterations: int = 0  # over all starts of this row
    solves: int = 0  # solver calls of this row
    wall_s: float = 0.0
    cpu_s: float = 0.0
    refined_cost: float = NAN  # of the same pattern on the finest mesh that was asked, NaN when none was
    refined_knots: int = 0  # knots a phase of that mesh, 0 when none was asked
    trajectory: Trajectory | None = None
    multipliers: Multipliers | None = None
