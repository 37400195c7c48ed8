"""Keeping a gait: at a border between two gaits a noisy command must not change the gait at every call."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from numbers import Real

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas

MARGIN = 0.05  # of the best gait's cost
NEAR = 0.1  # steps of the map's grid

ChancesAt = Callable[[Array], Sequence[float]]  # at a place [a] the probability of each gait to be the best


def is_kept(atlas: Atlas, chances: ChancesAt, steps: Array, place: Array, gait: int, margin: float) -> bool:
    """Whether a gait is predicted to cost at most 1 + margin times the best one's cost at a place [a], or near it.

    Costs count as the atlas prefers sheets by them: over many axes over the probability of their gait.

    Near is a tenth of a step [a] of the map's grid away along an axis: there are borders at which costs part by several
    per cent within a centimetre a second, so that no reasonable margin alone would stop the noise of a command. A gait
    that the atlas does not know there, or not as well as the best one, is not kept.
    """
    return any(_excess(atlas, chances, each, gait) <= margin for each in _around(place, NEAR * steps))


def _around(place: Array, moves: Array) -> Iterator[Array]:
    yield place
    for move in np.diag(moves):
        yield place - move
        yield place + move


def _excess(atlas: Atlas, chances: ChancesAt, place: Array, gait: int) -> float:
    """By how much a gait costs more than the best one, relative; infinite where that is not known."""
    of_gaits = chances(place) if atlas.is_wide else None
    ranked = atlas.ranked(place, of_gaits)
    own = next((sheet for sheet in ranked if atlas.sheets[sheet].gait == gait), None)
    if own is None:
        return math.inf
    by, believed = atlas.preferred(*atlas.costs(place), of_gaits)
    if believed[ranked[0]] and not believed[own]:
        return math.inf
    return float(by[own] / by[ranked[0]]) - 1


def checked_margin(margin: object) -> float:
    """A margin of cost, relative. Raises ValueError."""
    if isinstance(margin, bool) or not isinstance(margin, Real) or not 0 <= float(margin) < math.inf:
        raise ValueError(f"margin = {margin!r}: must be a part of the best gait's cost, 0 or more")
    return float(margin)
