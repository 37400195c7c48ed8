"""Which of the gaits that tie at a task a classifier learns there: the one that the neighbouring tasks agree on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from gaitflow.tables.schema import task_columns

NEAREST = 8

Cell = tuple[int, ...]  # place of a task on the grid: the index of its value on each axis


def neighbourhood_labels(labels: pd.DataFrame) -> list[str]:
    """A label for each row of `labels`, out of its `ties` (or its own `label` where it has none).

    On the grid it is the one most common among the neighbours (up to 8 with two axes), iterated until nothing changes;
    for a held-out task the one most common at the corners of the grid cell it lies in. Where tasks are scattered it is
    the most common one of the NEAREST tasks, by distance over each axis' range. Held-out tasks influence no other
    label. `labels` has the task's columns, `label` and `ties`.
    """
    *axes, _ = task_columns(labels.columns)
    held_out = labels["split"].to_numpy() == "held_out"
    if (labels["split"] == "sampled").any():
        return _scattered(labels, axes, held_out)
    values = [np.unique(labels.loc[~held_out, axis]) for axis in axes]
    places = np.column_stack([np.searchsorted(line, labels[axis]) for line, axis in zip(values, axes, strict=True)])
    rows: list[Cell] = [tuple(map(int, place)) for place in places]
    cells = {cell: index for index, cell in enumerate(rows) if not held_out[index]}
    ranged = [len(line) > 1 for line in values]
    around = _steps((-1, 0, 1), ranged)
    result, ties = labels["label"].tolist(), labels["ties"].tolist()
    on_grid = {cell: result[index] for cell, index in cells.items()}
    # One task at a time, in a fixed order, and only for a strict majority: each change makes more neighbours agree,
    # so the sweeps end, and they end the same way every time.
    changed = True
    while changed:
        changed = False
        for cell in sorted(cells):
            choice = _most_common(on_grid, _moved(cell, around), ties[cells[cell]], on_grid[cell])
            changed |= choice != on_grid[cell]
            on_grid[cell] = choice
    for cell, index in cells.items():
        result[index] = on_grid[cell]
    corners = [(0,) * len(axes), *_steps((0, -1), ranged)]
    for index in map(int, np.flatnonzero(held_out)):
        result[index] = _most_common(on_grid, _moved(rows[index], corners), ties[index], result[index])
    return result


def _scattered(labels: pd.DataFrame, axes: Sequence[str], held_out: NDArray[np.bool_]) -> list[str]:
    own, ties = labels["label"].tolist(), labels["ties"].tolist()
    places = labels[list(axes)].to_numpy(dtype=float)
    made_from = np.flatnonzero(~held_out)
    spans = np.ptp(places[made_from], axis=0)
    places = places / np.where(spans > 0, spans, 1.0)
    result = []
    for index, (label, allowed) in enumerate(zip(own, ties, strict=True)):
        distances = np.linalg.norm(places[made_from] - places[index], axis=1)
        near = [own[other] for other in made_from[np.argsort(distances, kind="stable")] if other != index][:NEAREST]
        votes = Counter(gait for gait in near if gait in allowed)
        result.append(max([label, *allowed], key=lambda gait: votes[gait]) if votes else label)
    return result


def _steps(along: Sequence[int], ranged: Sequence[bool]) -> list[Cell]:
    """Every step but none at all, with one of `along` on each axis that has more than one value."""
    return [step for step in product(*(along if many else (0,) for many in ranged)) if any(step)]


def _moved(cell: Cell, steps: Iterable[Cell]) -> list[Cell]:
    return [tuple(place + more for place, more in zip(cell, step, strict=True)) for step in steps]


def _most_common(on_grid: Mapping[Cell, str], cells: Iterable[Cell], allowed: Sequence[str], current: str) -> str:
    votes = Counter(on_grid[cell] for cell in cells if cell in on_grid and on_grid[cell] in allowed)
    # `allowed` is sorted by cost: among equally common gaits the cheapest, unless the present label is one of them.
    return max([current, *allowed], key=lambda gait: votes[gait]) if votes else current
