"""What the nodes of an atlas say to a classifier: many more labelled tasks than the dataset has.

A label is the gait of the cheapest node at a task. The dataset's own tasks are left to the dataset, and so are tasks
where two gaits cost the same within the tie tolerance: there the label would be a coin's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitflow.atlas.grow import REFINE
from gaitflow.learn.classifier import Floats, Integers
from gaitflow.runtime.atlas import Atlas


@dataclass(frozen=True)
class NodeLabels:
    """Tasks [m, 2] (m/s, s), the numbers [m] of their gaits in the atlas, and the cells [m] of the map's grid."""

    tasks: Floats
    gaits: Integers
    cells: Integers


def node_labels(atlas: Atlas, tie_tolerance: float, refine: int = REFINE) -> NodeLabels:
    """The labels of an atlas with `refine` steps for each of the map's grid. Equal atlases give equal labels."""
    costs: dict[tuple[int, int], dict[int, float]] = {}
    for sheet in atlas.sheets:
        for (i, j), cost in zip(sheet.places.tolist(), sheet.costs.tolist(), strict=True):
            known = costs.setdefault((i, j), {})
            known[sheet.gait] = min(cost, known.get(sheet.gait, np.inf))
    kept = [
        (place, min(known, key=lambda gait: (known[gait], gait)))
        for place, known in sorted(costs.items())
        if (place[0] % refine or place[1] % refine) and _is_clear(sorted(known.values()), tie_tolerance)
    ]
    places = np.array([place for place, _ in kept], dtype=np.int64).reshape(-1, 2)
    axes = np.array(atlas.speeds), np.array(atlas.cycle_durations)
    return NodeLabels(
        tasks=np.column_stack([axes[0][places[:, 0]], axes[1][places[:, 1]]]).astype(np.float32),
        gaits=np.array([gait for _, gait in kept], dtype=np.int64),
        cells=(places[:, 0] // refine) * (len(atlas.cycle_durations) // refine + 1) + places[:, 1] // refine,
    )


def _is_clear(costs: Sequence[float], tie_tolerance: float) -> bool:
    return len(costs) == 1 or costs[1] > costs[0] * (1 + tie_tolerance)
