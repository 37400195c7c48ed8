"""Where the atlas picks another gait than the search found best: the gaits that it mistakes get nodes there.

At the tasks that were searched the costs of gaits are known. A gait without a node at a cliff is promised too cheap on
its far side; what it truly costs there is a node, and where it has no motion its border is looked for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd

from gaitflow.atlas.border import find_borders
from gaitflow.atlas.compress import cost_atlas
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import Place
from gaitflow.runtime.atlas import Atlas

ROUNDS = 4
NEAREST = 3  # nodes from which a place is tried

Known = Mapping[Place, Mapping[int, float]]  # at each searched place the excess of each gait with a motion, by number


def known_costs(costs: pd.DataFrame, column: str, gaits: Sequence[str], axes: Sequence[str]) -> Known:
    """What the frame of `gaitflow.dataset.labels.gait_costs` knows of some gaits, at tasks that are not held out.

    `column` says how `gaits` are called: by their names ("gait") or their keys ("gait_key"). `axes` are the map's.
    """
    known: dict[Place, dict[int, float]] = {}
    rows = costs[costs[column].isin(gaits) & (costs["split"] != "held_out")]
    for *place, gait, excess in rows[[*axes, column, "excess"]].itertuples(index=False, name=None):
        known.setdefault(tuple(place), {})[gaits.index(gait)] = excess
    return known


def settle(
    growth: Growth,
    gaits: Sequence[int],
    known: Known,
    tolerance: float,
    tell: Callable[[str], None] = lambda text: None,
) -> int:
    """Add nodes until an atlas picks a gait at most `tolerance` (relative) dearer than the best at each known place.

    `gaits` are the numbers of the gaits that the growth's full patterns realise. Returns at how many places another
    gait is still picked after ROUNDS, or when no more nodes can be added.
    """
    for number in range(ROUNDS):
        wrong = _mistakes(growth, gaits, known, tolerance)
        tell(f"other gaits than the search's at {len(wrong)} of {len(known)} tasks, round {number + 1}")
        if not _correct(growth, gaits, wrong, known):
            return len(wrong)
        growth.spread()
    return len(_mistakes(growth, gaits, known, tolerance))


def mistaken(atlas: Atlas, place: Place, costs: Mapping[int, float], tolerance: float) -> tuple[int, ...]:
    """The gait that the atlas picks and the one that it should, where the first costs too much; else nothing."""
    ranked = atlas.ranked(np.array(place))
    if not ranked or not costs:
        return ()
    picked, best = atlas.sheets[ranked[0]].gait, min(costs, key=lambda gait: costs[gait])
    return () if costs.get(picked, np.inf) <= tolerance else (picked, best)


def _mistakes(growth: Growth, gaits: Sequence[int], known: Known, tolerance: float) -> dict[Place, tuple[int, ...]]:
    atlas = cost_atlas(growth, gaits)
    found = {place: mistaken(atlas, place, costs, tolerance) for place, costs in known.items()}
    return {place: pair for place, pair in found.items() if pair}


def _correct(growth: Growth, gaits: Sequence[int], wrong: Mapping[Place, Sequence[int]], known: Known) -> bool:
    """Nodes of mistaken gaits' sheets at their places, or the borders of those without a motion; whether any is new."""
    before = sum(map(len, growth.nodes)) + sum(map(len, growth.infeasible))
    asked = [
        (sheet, place)
        for place, pair in wrong.items()
        for sheet, gait in enumerate(gaits)
        if gait in pair and growth.nodes[sheet]
    ]
    _add(growth, asked)
    find_borders(growth, [(sheet, place) for sheet, place in asked if gaits[sheet] not in known[place]])
    return sum(map(len, growth.nodes)) + sum(map(len, growth.infeasible)) > before


def _add(growth: Growth, asked: Sequence[tuple[int, Place]]) -> None:
    """Nodes of sheets at places, (sheet, place) each: from the dataset's own solution, else from the nearest nodes."""
    starts = {
        (sheet, place): [
            start
            for start in (growth.start_at(sheet, place), *growth.nearest(sheet, place, NEAREST))
            if start is not None
        ]
        for sheet, place in asked
        if place not in growth.nodes[sheet]
    }
    for attempt in range(1 + NEAREST):
        requests = [
            (sheet, place, each[attempt])
            for (sheet, place), each in starts.items()
            if place not in growth.nodes[sheet] and attempt < len(each)
        ]
        for (sheet, _, _), node in zip(requests, growth.solver.nodes(requests), strict=True):
            growth.keep(sheet, node)
