"""Labels from the atlas for classifiers: at many more tasks than the dataset has.

A label is the gait of least predicted cost at a task of a finer grid. The dataset's own tasks keep the dataset's
labels. Tasks where two gaits are predicted to cost the same within the tie tolerance get no label, because it would be
arbitrary.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from gaitflow.core.domain import Domain
from gaitflow.core.trajectory import Array
from gaitflow.learn.classifier import Floats, Integers
from gaitflow.runtime.atlas import SUPPORT, Atlas

FINEST = 4  # steps of the finer grid for one of the map's
MOST = 3000  # labelled tasks: what a classifier is still fitted to in seconds
SEED = 0


@dataclass(frozen=True)
class AtlasLabels:
    """Tasks [m, a] on the axes with a range, the numbers [m] of their gaits in the atlas, and their cells [m]."""

    tasks: Floats
    gaits: Integers
    cells: Integers


def atlas_labels(atlas: Atlas, domain: Domain, tie_tolerance: float, most: int = MOST) -> AtlasLabels:
    """The labels inside a domain, at most `most`. Equal atlases give equal labels."""
    places, cells = _finer(domain, most)
    gaits = np.array([_clear_gait(atlas, place, tie_tolerance) for place in places], dtype=np.int64)
    known = gaits >= 0
    return AtlasLabels(places[known].astype(np.float32), gaits[known], cells[known])


def picks(atlas: Atlas, places: Floats, probabilities: Floats) -> Integers:
    """The order [n, C] in which a map picks gaits at places [n, a]: what the atlas knows by `Atlas.by_cost`, the rest
    likeliest first by the classifier's probabilities [n, C], whose gaits are the atlas' own.
    """
    order = []
    likeliest = np.argsort(-probabilities, axis=1, kind="stable").tolist()
    for place, row, chances in zip(places, likeliest, probabilities.tolist(), strict=True):
        known = [atlas.sheets[sheet].gait for sheet in atlas.ranked(np.asarray(place, dtype=float), chances)]
        order.append(known + [gait for gait in row if gait not in known])
    return np.array(order, dtype=np.int64).reshape(probabilities.shape)


def _finer(domain: Domain, most: int) -> tuple[Array, Integers]:
    """Places [m, a] inside the domain that are no tasks of the grid, and the numbers [m] of the grid's cells."""
    grid = list(domain.axes.values())
    ways = [steps for steps in range(2, FINEST + 1) if np.prod([_points(len(each), steps) for each in grid]) <= most]
    steps = max(ways, default=2)
    axes = [_between(np.array(values), steps) for values in grid]
    shape = tuple(max(len(values) - 1, 1) for values in grid)
    found, cells = [], []
    for index in product(*(range(len(axis)) for axis in axes)):
        place = [float(axis[i]) for axis, i in zip(axes, index, strict=True)]
        if any(i % steps for i in index) and domain.contains(dict(zip(domain.axes, place, strict=True))):
            found.append(place)
            cell = [min(i // steps, size - 1) for i, size in zip(index, shape, strict=True)]
            cells.append(int(np.ravel_multi_index(cell, shape)))
    places, numbers = np.array(found).reshape(-1, len(grid)), np.array(cells, dtype=np.int64)
    if len(places) > most:
        kept = np.sort(np.random.default_rng(SEED).permutation(len(places))[:most])
        places, numbers = places[kept], numbers[kept]
    return places, numbers


def _points(values: int, steps: int) -> int:
    return (values - 1) * steps + 1


def _between(values: Array, steps: int) -> Array:
    at = np.arange(len(values)) * steps
    return np.interp(np.arange(_points(len(values), steps)), at, values)


def _clear_gait(atlas: Atlas, place: Array, tie_tolerance: float) -> int:
    """The gait that is predicted to cost least; -1 where that is not believed, or another one ties with it."""
    ranked = atlas.ranked(place)
    if not ranked:
        return -1
    costs, support = atlas.costs(place)
    first, *others = ranked
    if support[first] < SUPPORT or any(costs[other] <= costs[first] * (1 + tie_tolerance) for other in others):
        return -1
    return atlas.sheets[first].gait
