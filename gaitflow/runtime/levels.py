"""Bounds in a file of tensors: a byte for each, which says which of the few values that bounds have it is.

The values are in the tensor `levels` (float64, ascending). In older maps, and where bounds have more than 256 values,
there is none, and bounds are float64.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.runtime.tensor_file import TensorFile

LEVELS, MOST_LEVELS = "levels", 256


def levels_of(bounds: Iterable[Array]) -> Array | None:
    """All values that some bounds have; None where these are none or too many for a byte."""
    flat = [np.ravel(each) for each in bounds]
    levels = np.unique(np.concatenate(flat)) if flat else np.zeros(0)
    return levels if 0 < len(levels) <= MOST_LEVELS else None


def levelled(bounds: Array, levels: Array | None) -> NDArray[Any]:
    """Which level each bound is; the bounds themselves where there are no levels."""
    return bounds if levels is None else np.searchsorted(levels, bounds).astype(np.uint8)


def read_bounds(file: TensorFile, name: str, shape: tuple[int, ...]) -> Array:
    """The bounds in a tensor of a file, float64, read-only. Raises ArtifactError."""
    if LEVELS not in file.tensors:
        return file.array(name, shape, np.float64, finite=False)
    levels = file.array(LEVELS, (file.length(LEVELS),), np.float64, finite=False)
    if len(levels) > MOST_LEVELS or (levels[1:] <= levels[:-1]).any():
        file.refuse(LEVELS, f"are more than {MOST_LEVELS}, or not in ascending order")
    which = file.array(name, shape, np.uint8)
    if which.max(initial=0) >= len(levels):
        file.refuse(name, f"has level {which.max()}; there are {len(levels)}")
    bounds: Array = levels[which]
    bounds.flags.writeable = False
    return bounds
