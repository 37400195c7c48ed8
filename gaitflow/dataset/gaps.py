"""How far the labelled motions are from continuous ones between their knots, which no discrete constraint sees."""

from __future__ import annotations

import numpy as np
import pandas as pd

from gaitflow.core.check import step_gaps
from gaitflow.dataset.read import Solutions
from gaitflow.search.solution import Solution

GAP = "gap_between_knots"  # column of the labels


def gaps_between_knots(labels: pd.DataFrame, solutions: Solutions) -> list[float]:
    """For each label its motion's worst gap in one step, [m] or [rad]; NaN where there is no motion.

    The gap is the difference of base position or angles between the stored knot and the continuous motion that starts
    at the knot before under the same forces (`gaitflow.core.check.step_gaps`).
    """
    wanted = {
        (v, t, pattern)
        for v, t, pattern in zip(labels["speed"], labels["cycle_duration"], labels["pattern"], strict=True)
    }
    frame = solutions.frame()
    found: dict[tuple[float, float, str], float] = {}
    for index, key in enumerate(zip(frame["speed"], frame["cycle_duration"], frame["pattern"], strict=True)):
        if key in wanted:
            found[key] = gap_between_knots(solutions.record["scenario"], solutions[index])
    return [
        found.get((v, t, pattern), np.nan)
        for v, t, pattern in zip(labels["speed"], labels["cycle_duration"], labels["pattern"], strict=True)
    ]


def gap_between_knots(scenario: dict[str, object], solution: Solution) -> float:
    """Worst gap of one motion, [m] or [rad]; NaN without a trajectory. `scenario` is `Scenario.as_data()`."""
    if solution.trajectory is None:
        return float("nan")
    gaps = step_gaps(scenario, solution.trajectory)
    return float(np.abs(gaps[:, : gaps.shape[1] // 2]).max())
