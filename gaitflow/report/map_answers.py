"""A map's own answers at the tasks of its grid, in the form of labels, for maps whose dataset is not at hand."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.dataset.labels import LABELS
from gaitflow.report.predicted import known_gaits
from gaitflow.runtime import GaitMap
from gaitflow.runtime.artifact import Artifact

_UNKNOWN = {"refined_cost": np.nan, "cost_error": np.nan, "resolved": False}  # what only solving on finer meshes tells


def map_answers(artifact: Artifact) -> pd.DataFrame:
    """One row a task of the map's grid: the task's columns and LABELS, as the map predicts them.

    Costs and margins are the atlas' predictions; the gait is what `select` names. Where the grid had no feasible gait
    the status is "infeasible". A cost that the atlas does not know is NaN.
    """
    manifest, gait_map = artifact.manifest, GaitMap(artifact)
    axes, tolerance = manifest.domain.axes, float(manifest.scenario["learning"]["tie_tolerance"])
    columns = manifest.space.columns
    rows = []
    for place in product(*axes.values()):
        values = dict(zip(axes, place, strict=True))
        task = manifest.space.task(values)
        row = dict(zip(columns, task.on(columns), strict=True)) | {"split": task.split}
        rows.append(row | _label(artifact, gait_map, values, tolerance))
    return pd.DataFrame(rows, columns=[*columns, "split", *LABELS])


def _label(artifact: Artifact, gait_map: GaitMap, values: Mapping[str, Any], tolerance: float) -> dict[str, Any]:
    choice = gait_map.select(**values)
    if choice.gait is None:
        nothing = dict.fromkeys(("gait", "gait_key", "pattern", "runner_up", "label"), "")
        return _UNKNOWN | nothing | {"status": "infeasible", "cost": np.nan, "margin": np.nan, "ties": []}
    known = known_gaits(artifact, values)
    cost = known[0].cost if known else np.nan
    others = sorted(one.cost / cost - 1 for one in known[1:])
    keys = {gait.name: gait.key for gait in artifact.manifest.gaits}
    return _UNKNOWN | {
        "status": "solved",
        "gait": choice.gait,
        "gait_key": keys[choice.gait],
        "pattern": choice.pattern,
        "cost": cost,
        "margin": others[0] if others else np.inf,
        "runner_up": min(known[1:], key=lambda one: one.cost).gait if others else "",
        "ties": [choice.gait, *(one.gait for one in known[1:] if one.cost <= (1 + tolerance) * cost)],
        "label": choice.gait,
    }
