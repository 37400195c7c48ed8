"""What the labelled motions do between their knots, which no discrete constraint sees, and what they really cost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.core.check import between_knots, cost
from gaitflow.dataset.read import Solutions
from gaitflow.search.solution import Solution
from gaitflow.tables.schema import task_columns

GAP = "gap_between_knots"  # [m] or [rad]: largest distance from the continuous motion under the same forces
KINDS = {
    "dynamics": GAP,
    "kinematic box": "box_between_knots",  # [m] how far a foot leaves its box
    "friction": "friction_between_knots",  # over m g
    "penetration": "penetration_between_knots",  # [m]
}  # what `gaitflow.core.check.between_knots` tells, on a grid ten times finer: the column of the labels
COST_CHECK = "cost_check"  # (cost - cost integrated anew along the motion) / that
COLUMNS = (*KINDS.values(), COST_CHECK)


def with_motion_checks(labels: pd.DataFrame, solutions: Solutions) -> pd.DataFrame:
    """The labels with the columns COLUMNS: `motion_checks` of each label's motion, NaN where there is none."""
    frame, scenario = solutions.frame(), solutions.record["scenario"]
    key = [*task_columns(labels.columns), "pattern"]
    ordered = frame.sort_values("cost", ascending=False, na_position="first")  # so that the cheapest comes last
    places = dict(zip(zip(*(ordered[name] for name in key), strict=True), ordered.index, strict=True))
    nothing = dict.fromkeys(COLUMNS, np.nan)
    checks = [
        motion_checks(scenario, solutions[places[row]]) if row in places else nothing
        for row in zip(*(labels[name] for name in key), strict=True)
    ]
    return labels.assign(**{name: [check[name] for check in checks] for name in COLUMNS})


def motion_checks(scenario: Mapping[str, Any], solution: Solution) -> dict[str, float]:
    """COLUMNS of one motion; NaN without a trajectory. `scenario` is `Scenario.as_data()`."""
    motion = solution.trajectory
    if motion is None:
        return dict.fromkeys(COLUMNS, np.nan)
    found = between_knots(scenario, motion, solution.task, solution.pattern)
    integrated = cost(scenario, motion, solution.task, solution.pattern)
    least = np.finfo(float).tiny
    return {column: found[kind] for kind, column in KINDS.items()} | {
        COST_CHECK: (solution.cost - integrated) / max(abs(integrated), least)
    }
