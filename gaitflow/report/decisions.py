"""What a map chooses on a fine grid of two axes, asked for everywhere only along the borders of its regions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Floats = NDArray[np.float64]
Chosen = NDArray[np.integer[Any]]
# Values [n] by axis, one array for each axis with a range -> index [n] of the chosen gait, -1 outside the domain.
Select = Callable[[Mapping[str, Floats]], Chosen]

STRIDE = 2  # cells from one that is asked for to the next, away from borders
AROUND = np.ones((3, 3))


def decisions(select: Select, along: Mapping[str, Floats], at: Mapping[str, float], gaits: int) -> Chosen:
    """Index of the gait chosen in each cell [rows, columns], -1 outside the domain.

    `along` has the values of the axis along x and, if there is a second one, along y, which are the columns and the
    rows; with one axis there is one row. `at` has the values of the further axes. Every second cell each way is asked
    for, then all cells whose neighbours differ, so a region is missed only where it is one cell wide and touches no
    border that was met. Raises ValueError when `select` answers with an index that is none of so many gaits.
    """
    names, values = list(along), list(along.values())
    columns, rows = values[0], values[1] if len(values) > 1 else np.zeros(1)

    def ask(cells: NDArray[np.bool_]) -> Chosen:
        row, column = np.nonzero(cells)
        asked = dict(zip(names, (columns[column], rows[row]), strict=False))
        answers = np.asarray(select(asked | {axis: np.full(len(row), value) for axis, value in at.items()}))
        if answers.min() < -1 or answers.max() >= gaits:
            raise ValueError(
                f"select answered {answers.min()} to {answers.max()}, but the gaits are numbered 0 to {gaits - 1} "
                "and -1 is outside the domain; pass the gaits in the order of the classifier's classes"
            )
        return answers

    nearest_row, nearest_column = _strided(len(rows)), _strided(len(columns))
    known = np.outer(nearest_row == np.arange(len(rows)), nearest_column == np.arange(len(columns)))
    chosen = np.full(known.shape, -1)
    chosen[known] = ask(known)
    chosen = chosen[np.ix_(nearest_row, nearest_column)]
    while (left := _beside_another(chosen) & ~known).any():
        chosen[left] = ask(left)
        known |= left
    return chosen


def _strided(count: int) -> NDArray[np.intp]:
    """Of each of `count` cells in a row the cell before it that is asked for; the last one is asked for itself."""
    nearest = np.arange(count) // STRIDE * STRIDE
    nearest[-1] = count - 1
    return nearest


def _beside_another(chosen: Chosen) -> NDArray[np.bool_]:
    """Which cells have another choice among the eight around them."""
    filters = (ndimage.maximum_filter, ndimage.minimum_filter)
    high, low = (of_nine(chosen, footprint=AROUND, mode="nearest") for of_nine in filters)
    return np.asarray(high != low)
