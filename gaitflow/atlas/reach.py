"""Tasks of the grid that no gait has reached: tried again before the map's domain is taken from those that one has.

A gait that spreads leaves a place after a few attempts in vain, since most gaits that it leaves have no motion there.
Where all of them left a place, a hole in the domain may be theirs only: half a cheetah lost 4 of 315 tasks so.
"""

from __future__ import annotations

from itertools import product

from gaitflow.atlas.border import try_places
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import Place


def reach(growth: Growth) -> int:
    """Try every gait at the places of the grid beside its nodes where none has one; how many are reached.

    A gait that is found spreads, and places beside what it has reached are tried next. Where a gait has no motion its
    place is taken to have none.
    """
    reached, tried = 0, set[tuple[int, Place]]()
    while places := [each for each in _beside(growth) if each not in tried]:
        tried |= set(places)
        before = len(_unreached(growth))
        try_places(growth, places)
        growth.spread()
        reached += before - len(_unreached(growth))
    return reached


def _unreached(growth: Growth) -> list[Place]:
    """The places of the grid inside the growth's domain at which no gait has a node."""
    inside = filter(growth.inside, product(*growth.grid))
    return [place for place in inside if not any(place in nodes for nodes in growth.nodes)]


def _beside(growth: Growth) -> list[tuple[int, Place]]:
    """The patterns that have a node one step of the grid away from a place that is unreached, with that place."""
    return [
        (sheet, place)
        for place in _unreached(growth)
        for sheet, nodes in enumerate(growth.nodes)
        if any(near in nodes for near in growth.neighbours(place))
    ]
