"""What is written down of an atlas beside its bytes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitflow.atlas.judge import Predictions
    from gaitflow.runtime.atlas import Atlas


def atlas_record(
    gaits: Sequence[str], atlas: Atlas, size: int, judged: Predictions, solves: int, missed: int
) -> dict[str, Any]:
    """Plain JSON data: its `gaits`, nodes a sheet, bytes (`size`), how good it is, and what it took.

    `missed_labels` counts the searched tasks at which it picks another gait than the search found best.
    """
    predictions = {key: None if math.isnan(value) else value for key, value in asdict(judged).items()}
    return {
        "gaits": list(gaits),
        "nodes": {f"{gaits[sheet.gait]} {sheet.pattern}": len(sheet.tasks) for sheet in atlas.sheets},
        "modes": max((len(sheet.modes) for sheet in atlas.sheets), default=0),
        "bytes": size,
        "predictions": predictions,
        "missed_labels": missed,
        "solves": solves,
    }
