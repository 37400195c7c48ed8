"""Where the fast method may start for a task, by what an atlas knows: the best start first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas
from gaitflow.solvers.point import Point

# Barriers of the starts, by what they are of. Far starts take a higher one. Of 400 near solves the first start, with
# a matrix of the right inertia, found 94 %, of which 0.5 % were 0.1 % dearer than the best known; without looking after
# the inertia 4.8 %. Of the 6 % the second one found 92 %, more than any other.
PRIMAL_BARRIER = 1e-2  # the prediction without its multipliers
NODE_BARRIER = 1e-3


@dataclass(frozen=True)
class Start:
    """A point near the central path at `barrier`, for a cost that is divided by `unit`, which is expected.

    careful: each step looks after the matrix's inertia, as a prediction allows that is of this very task.
    """

    point: Point
    unit: float
    barrier: float
    careful: bool = False


def starts_of(atlas: Atlas, sheet: int, place: Array) -> Iterator[Start]:
    """The starts of a sheet at a place [axes]; without a prediction that of a node alone."""
    space = atlas.sheets[sheet].space
    predicted = atlas.predict(sheet, place)
    if predicted is not None:
        point = space.decode(predicted.point)
        yield Start(point, predicted.cost, atlas.barrier, careful=True)
        yield Start(_primal(point), predicted.cost, PRIMAL_BARRIER)
    # The nearest node says little that is new: the prediction is mostly its own.
    node = atlas.nearest(sheet, place, 2)[-1]
    yield Start(space.decode(node.point), node.cost, NODE_BARRIER)


def _primal(point: Point) -> Point:
    """The point without its multipliers: those of bounds follow from the barrier."""
    nothing = np.zeros_like(point.lower)
    return Point(point.free, np.zeros_like(point.rows), nothing, nothing)
