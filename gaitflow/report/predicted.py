"""What a map's atlas knows at a task: the cost of each gait, and the solved tasks that it predicts it from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.runtime.artifact import Artifact


@dataclass(frozen=True)
class Known:
    """A gait by one of its patterns: its predicted cost, in the scenario's units, and the nearest node.

    `node` has that node's values on the map's axes, `node_cost` its cost when it was solved.
    """

    gait: str
    pattern: str
    cost: float
    node: Mapping[str, float]
    node_cost: float


def known_gaits(artifact: Artifact, task: Mapping[str, float]) -> tuple[Known, ...]:
    """Every gait that the atlas knows at a task, by its cheapest pattern, in the order in which the map takes them.

    `task` has a value on each of the map's axes.
    """
    atlas, gaits, scale = artifact.atlas, artifact.manifest.gaits, artifact.manifest.cost_scale
    place: Array = np.array([task[axis] for axis in atlas.axes])
    costs, _ = atlas.costs(place)
    found = []
    chances = artifact.classifier(place[None, :].astype(np.float32))[0].tolist()
    for number in atlas.ranked(place, chances):
        sheet = atlas.sheets[number]
        nearest = int(np.argmin(np.linalg.norm((sheet.tasks - place) / atlas.steps, axis=1)))
        node = dict(zip(atlas.axes, sheet.tasks[nearest].tolist(), strict=True))
        cost, node_cost = float(costs[number] * scale), float(sheet.costs[nearest] * scale)
        found.append(Known(gaits[sheet.gait].name, sheet.pattern, cost, node, node_cost))
    return tuple(found)
