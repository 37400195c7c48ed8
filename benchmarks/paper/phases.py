"""What more phases gain: the labels of a scenario against those of the same one with more phases on the same mesh.

The paper stops at four phases in space, 16^4 patterns; with eight there are 16^8 (section IV.C).
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from benchmarks.document import document
from benchmarks.paper import stances
from gaitflow.config.scenario import Scenario
from gaitflow.tables.schema import task_columns

CHANGED = ("transcription", "stances_per_leg")
NOTES = (
    "cost: with the scenario's phases; free_cost, free_gait: with more of them. cost_fall is the share by which the "
    "cost falls; changed tells whether the gait is another one. A phase of the scenario is two of half the knots and "
    "half the least duration, so each of its motions is allowed with more phases, too: dearer counts tasks where the "
    "search missed that.",
    "Halving the least duration helps by itself. control_cost, control_gait: as many phases as the scenario with the "
    "least duration of the other; fall_by_limit is the share by which that alone lowers the cost, fall_by_phases what "
    "more phases add to it: negative where they are dearer than the control, which they need not contain, since a "
    "phase of it has twice their knots and is no longer than theirs.",
    "excluded counts tasks whose cheapest gait with more phases has a leg with no stance or with several. Tasks are "
    "those of the grid that both scenarios have.",
)


def run(
    scenario: Scenario,
    more: Scenario,
    labels: pd.DataFrame,
    more_labels: pd.DataFrame,
    control: pd.DataFrame | None = None,
) -> dict[str, Any]:
    """The document: a row a grid task in common; `labels` and `more_labels` are those of `scenario` and of `more`.

    `control` are labels of `scenario` with the least phase duration of `more`. Raises ValueError unless the scenarios
    differ in nothing but stances and the transcription, where `more` has more phases and as many knots a cycle, or
    when they have no task in common.
    """
    for part in stances.differing_parts(scenario, more):
        if part not in CHANGED:
            raise ValueError(f"{more.name}: {part} differs from that of {scenario.name}; only phases and stances may")
    few, many = scenario.transcription, more.transcription
    if many.phases <= few.phases or many.phases * many.knots_per_phase != few.phases * few.knots_per_phase:
        raise ValueError(
            f"{more.name} has {many.phases} phases of {many.knots_per_phase} knots, {scenario.name} {few.phases} of "
            f"{few.knots_per_phase}; it must have more phases and as many knots in all"
        )
    rows = stances.compare(labels, more_labels)
    if control is not None:
        rows = [row | beside(row, control) for row in rows]
    return document("phases", more.name, rows, stances.summarise(rows) | falls(rows), NOTES)


def beside(row: Mapping[str, Any], control: pd.DataFrame) -> dict[str, Any]:
    """The control's gait and cost at a row's task, and how the fall of the cost divides; None where it has no label."""
    axes = [column for column in task_columns(control.columns) if column != "split"]
    there = (control[axes] == [row[axis] for axis in axes]).all(axis=1)
    found = control[there & (control["status"] == "solved")]
    if found.empty or row["cost"] is None or row["free_cost"] is None:
        return dict.fromkeys(("control_gait", "control_cost", "fall_by_limit", "fall_by_phases"))
    cost = float(found["cost"].iloc[0])
    return {
        "control_gait": str(found["gait"].iloc[0]),
        "control_cost": cost,
        "fall_by_limit": 1 - cost / row["cost"],
        "fall_by_phases": 1 - row["free_cost"] / cost,
    }


def falls(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Median, least and largest of what the limit and the phases do; nothing without a control."""
    summary: dict[str, Any] = {}
    for name in ("fall_by_limit", "fall_by_phases"):
        values = [row[name] for row in rows if row.get(name) is not None]
        if values:
            summary |= {
                f"{name}_median": statistics.median(values), f"{name}_min": min(values), f"{name}_max": max(values)
            }  # fmt: skip
    return summary
