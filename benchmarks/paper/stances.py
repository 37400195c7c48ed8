"""What one stance per leg costs: the labels of a scenario against those of the same one without that setting.

Every gait of Fig. 5 has one stance per leg and cycle, but the paper states no such constraint.
"""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.document import document
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern
from gaitflow.dataset.labels import relative_cost
from gaitflow.tables.schema import task_columns

SAME_COST = 1e-6  # relative: the tolerance of a solve
NOTES = (
    "A label changes when the cheapest gait is another one; beyond ties when the gait with one stance is not among "
    "those that tie with the cheapest one either. cost_fall is the share by which the cost falls without the "
    "constraint. excluded counts tasks whose cheapest gait has a leg with no stance or with several.",
    "dearer counts tasks whose cost is higher without the constraint: all its motions are still allowed there, so the "
    "search missed one. Tasks are those of the grid that both scenarios have.",
)


def run(scenario: Scenario, free: Scenario, labels: pd.DataFrame, free_labels: pd.DataFrame) -> dict[str, Any]:
    """The document: a row a grid task. `labels` and `free_labels` are those of `scenario` and of `free`.

    Raises ValueError unless the scenarios differ in nothing but `stances_per_leg`, which is 1 and null, or when they
    have other tasks than the labels.
    """
    for part in differing_parts(scenario, free):
        if part != "stances_per_leg":
            raise ValueError(f"{free.name}: {part} differs from that of {scenario.name}; only stances_per_leg may")
    if (scenario.stances_per_leg, free.stances_per_leg) != (1, None):
        raise ValueError(
            f"stances_per_leg is {scenario.stances_per_leg} in {scenario.name} and {free.stances_per_leg} in "
            f"{free.name}; give one scenario with 1, then one with null"
        )
    rows = compare(labels, free_labels)
    return document("stances", scenario.name, rows, summarise(rows), NOTES)


def differing_parts(one: Scenario, other: Scenario) -> list[str]:
    """The parts of two scenarios' problems that are not the same, fixed values of the tasks' axes among them."""
    parts = one.problem_data | {"axes": [one.problem_data["axes"], one.tasks.space.fixed]}
    others = other.problem_data | {"axes": [other.problem_data["axes"], other.tasks.space.fixed]}
    return [part for part in parts if parts[part] != others[part]]


def compare(labels: pd.DataFrame, free_labels: pd.DataFrame) -> list[dict[str, Any]]:
    """A row for each grid task that both frames have. Raises ValueError when there is none."""
    axes = [column for column in task_columns(labels.columns) if column != "split"]
    one, free = (frame[frame["split"] == "grid"].set_index(axes) for frame in (labels, free_labels))
    common = [task for task in one.index if task in free.index]
    if not common:
        raise ValueError(
            f"the labels have {len(one)} and {len(free)} grid tasks and none in common; choose other grids"
        )
    return [dict(zip(axes, task, strict=True)) | _row(one.loc[task], free.loc[task]) for task in common]


def summarise(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """How many labels change, by how much the cost falls, and which gaits win where they do."""
    compared = [row for row in rows if row["cost"] is not None and row["free_cost"] is not None]
    changed = [row for row in compared if row["changed"]]
    falls = [row["cost_fall"] for row in compared]
    falls_changed = [row["cost_fall"] for row in changed]
    return {
        "tasks": len(rows),
        "compared": len(compared),
        "changed": len(changed),
        "changed_beyond_ties": sum(row["changed_beyond_ties"] for row in compared),
        "excluded": sum(row["excluded"] for row in rows),
        "cost_fall_median": statistics.median(falls) if falls else None,
        "cost_fall_max": max(falls, default=None),
        "cost_fall_median_of_changed": statistics.median(falls_changed) if falls_changed else None,
        "dearer": sum(row["dearer"] for row in compared),
        "only_found_without": sum(row["cost"] is None and row["free_cost"] is not None for row in rows),
        "only_found_with": sum(row["cost"] is not None and row["free_cost"] is None for row in rows),
        "winners": dict(Counter(row["free_gait"] for row in changed).most_common()),
    }


def _row(one: Any, free: Any) -> dict[str, Any]:
    cost, free_cost = (float(row["cost"]) if row["status"] == "solved" else None for row in (one, free))
    both = cost is not None and free_cost is not None
    fall = -float(relative_cost(np.asarray(free_cost), cost)) if cost is not None and free_cost is not None else None
    wins = Pattern.from_text(free["gait_key"]) if free_cost is not None else None
    return {
        "gait": str(one["gait"]) or None,
        "free_gait": str(free["gait"]) or None,
        "cost": cost,
        "free_cost": free_cost,
        "cost_fall": fall,
        "changed": both and one["gait"] != free["gait"],
        "changed_beyond_ties": both and one["gait"] not in list(free["ties"]),
        "excluded": wins is not None and any(wins.touchdowns(leg) != 1 for leg in range(wins.legs)),
        "dearer": fall is not None and fall < -SAME_COST,
    }
