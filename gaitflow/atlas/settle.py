"""Where the atlas picks another gait than the search found best: the gaits that it mistakes get nodes there.

At the tasks that were searched the costs of gaits are known. A gait without a node at a cliff is promised too cheap on
its far side; what it truly costs there is a node, and where it has no motion there are nodes on the way to that place.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gaitflow.atlas.grow import DECIMALS, Growth
from gaitflow.atlas.node import Place
from gaitflow.runtime.atlas import Atlas

ROUNDS = 4
ON_THE_WAY = (1 / 2, 3 / 4, 7 / 8, 15 / 16)  # from the nearest node to a place where a gait has no motion

Known = Mapping[Place, Mapping[int, float]]  # at each searched place the excess of each gait with a motion, by number


def settle(
    growth: Growth,
    compiled: Callable[[], Atlas],
    known: Known,
    tolerance: float,
    tell: Callable[[str], None] = lambda text: None,
) -> int:
    """Add nodes until the atlas picks a gait at most `tolerance` (relative) dearer than the best at each known place.

    `compiled` makes the atlas of the nodes that there are, its sheets in their order. Returns at how many places it
    still picks another gait after ROUNDS, or when no more nodes can be added.
    """
    for number in range(ROUNDS):
        atlas = compiled()
        sheets = [sheet for sheet, nodes in enumerate(growth.nodes) if nodes]
        wrong = {place: mistaken(atlas, place, costs, tolerance) for place, costs in known.items()}
        wrong = {place: gaits for place, gaits in wrong.items() if gaits}
        tell(f"other gaits than the search's at {len(wrong)} of {len(known)} tasks, round {number + 1}")
        added = [_correct(growth, atlas, sheets, place, gaits) for place, gaits in wrong.items()]
        if not any(added):
            return len(wrong)
        growth.spread()
    atlas = compiled()
    return sum(bool(mistaken(atlas, place, costs, tolerance)) for place, costs in known.items())


def mistaken(atlas: Atlas, place: Place, costs: Mapping[int, float], tolerance: float) -> tuple[int, ...]:
    """The gait that the atlas picks and the one that it should, where the first costs too much; else nothing."""
    ranked = atlas.ranked(np.array(place))
    if not ranked or not costs:
        return ()
    picked, best = atlas.sheets[ranked[0]].gait, min(costs, key=lambda gait: costs[gait])
    return () if costs.get(picked, np.inf) <= tolerance else (picked, best)


def _correct(growth: Growth, atlas: Atlas, sheets: Sequence[int], place: Place, gaits: Sequence[int]) -> bool:
    """Nodes of some gaits' sheets at a place, or as near to it as they have a motion; whether any is new."""
    added = False
    for number, sheet in enumerate(atlas.sheets):
        if sheet.gait in gaits:
            tried = [place, *_on_the_way(growth, sheets[number], place)]
            added |= any(_node_at(growth, atlas, sheets[number], number, near) for near in tried)
    return added


def _node_at(growth: Growth, atlas: Atlas, sheet: int, number: int, place: Place) -> bool:
    """Whether a node of a sheet could be added: from the dataset's own solution, its prediction or its neighbours."""
    asked = np.array(place)
    starts = [growth.start_at(sheet, place), atlas.predict(number, asked), *atlas.nearest(number, asked, 2)]
    return place not in growth.nodes[sheet] and any(
        growth.keep(sheet, growth.solver.node(sheet, place, start)) for start in starts if start is not None
    )


def _on_the_way(growth: Growth, sheet: int, place: Place) -> list[Place]:
    """Places from a sheet's node nearest to a place towards it."""
    if place in growth.nodes[sheet]:
        return []
    asked = np.array(place)
    nodes = np.array(sorted(growth.nodes[sheet]))
    nearest = nodes[np.linalg.norm((nodes - asked) / growth.steps, axis=1).argmin()]
    places = [nearest + share * (asked - nearest) for share in ON_THE_WAY]
    return [tuple(round(float(x), DECIMALS) for x in each) for each in places]
