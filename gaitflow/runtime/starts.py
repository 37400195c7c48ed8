"""Where the fast method may start for a task, by what an atlas knows: the best start first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas
from gaitflow.solvers.point import GaitSpace, Point

# Barriers of the starts, by what they are of. Far starts take a higher one. Of 400 near solves the first start, with
# a matrix of the right inertia, found 94 %, of which 0.5 % were 0.1 % dearer than the best known; without looking after
# the inertia 4.8 %. Of the 6 % the second one found 92 %, more than any other.
PRIMAL_BARRIER = 1e-2  # the prediction without its multipliers
NODE_BARRIER = 1e-3
# Over more than NEAR_AXES axes the nominal start is better than any of the atlas': over ANYmal's four it found a motion
# for all of 37 candidates, in 23 iterations, and for 96 % of 1,120, in 25; predictions for 92 % of the 37, in 24.
NOMINAL_BARRIER = 1e-2

Nominal = Callable[[], Array]  # w [nw] of a level base that follows the command, from which searches start, too


@dataclass(frozen=True)
class Start:
    """A point near the central path at `barrier`, for a cost that is divided by `unit`, which is expected.

    careful: each step looks after the matrix's inertia, as a start allows that is of this very task.
    """

    point: Point
    unit: float
    barrier: float
    careful: bool = False


def starts_of(atlas: Atlas, sheet: int, place: Array, nominal: Nominal) -> Iterator[Start]:
    """The starts of a sheet at a place [axes]: from its prediction, where there is one, from a node, the `nominal` one.

    Over more than NEAR_AXES axes the nominal one comes first.
    """
    space = atlas.sheets[sheet].space
    predicted = atlas.predict(sheet, place)
    known = predicted or atlas.nearest(sheet, place, 1)[0]
    if atlas.is_wide:
        yield _from_nominal(space, nominal, known.cost)
    if predicted is not None:
        point = space.decode(predicted.point)
        yield Start(point, predicted.cost, atlas.barrier, careful=True)
        yield Start(_primal(space, point.free), predicted.cost, PRIMAL_BARRIER)
    # The nearest node says little that is new: the prediction is mostly its own.
    node = atlas.nearest(sheet, place, 2)[-1]
    yield Start(space.decode(node.point), node.cost, NODE_BARRIER)
    if not atlas.is_wide:
        yield _from_nominal(space, nominal, known.cost)


def _from_nominal(space: GaitSpace, nominal: Nominal, cost: float) -> Start:
    return Start(_primal(space, nominal()[space.free]), cost, NOMINAL_BARRIER, careful=True)


def _primal(space: GaitSpace, free: Array) -> Point:
    """Free variables [nF] without multipliers: those of bounds follow from the barrier."""
    nothing = np.zeros(len(space.has_lower))
    return Point(free, np.zeros(space.rows), nothing, nothing)
