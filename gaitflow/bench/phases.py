"""What more phases gain: the labels of a scenario against those of the same one with more phases on the same mesh.

The paper stops at four phases in space, 16^4 patterns; with eight there are 16^8 (section IV.C).
"""

from __future__ import annotations

from typing import Any

import pandas as pd

from gaitflow.bench import stances
from gaitflow.bench.document import document
from gaitflow.dataset.units import PROBLEM_FIELDS
from gaitflow.scenario import Scenario

CHANGED = ("transcription", "stances_per_leg")
NOTES = (
    "cost: with the scenario's phases; free_cost, free_gait: with more of them. cost_fall is the share by which the "
    "cost falls; changed tells whether the gait is another one. A phase of the scenario is two of half the knots and "
    "half the least duration, so each of its motions is allowed with more phases, too: dearer counts tasks where the "
    "search missed that.",
    "excluded counts tasks whose cheapest gait with more phases has a leg with no stance or with several. Tasks are "
    "those of the grid that both scenarios have.",
)


def run(scenario: Scenario, more: Scenario, labels: pd.DataFrame, more_labels: pd.DataFrame) -> dict[str, Any]:
    """The document: a row a grid task in common; `labels` and `more_labels` are those of `scenario` and of `more`.

    Raises ValueError unless the scenarios differ in nothing but stances and the transcription, where `more` has more
    phases and as many knots a cycle, or when they have no task in common.
    """
    for field in PROBLEM_FIELDS:
        if field not in CHANGED and getattr(scenario, field) != getattr(more, field):
            raise ValueError(f"{more.name}: {field} differs from that of {scenario.name}; only phases and stances may")
    few, many = scenario.transcription, more.transcription
    if many.phases <= few.phases or many.phases * many.knots_per_phase != few.phases * few.knots_per_phase:
        raise ValueError(
            f"{more.name} has {many.phases} phases of {many.knots_per_phase} knots, {scenario.name} {few.phases} of "
            f"{few.knots_per_phase}; it must have more phases and as many knots in all"
        )
    rows = stances.compare(labels, more_labels)
    return document("phases", more.name, rows, stances.summarise(rows), NOTES)
