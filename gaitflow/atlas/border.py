"""Where the motions of a gait end: nodes on one side of a border, places without a motion on the other.

A gait's cost hardly changes up to a limit of the robot, as the reach of a leg, so no cost tells where the gait ends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gaitflow.atlas.grow import DECIMALS, Growth
from gaitflow.atlas.node import Node, Place, Request

NARROW = 1 / 16  # steps between the two sides of a border that is known well enough
STARTS = 2  # nearest nodes from which a place is tried, and then the nominal start
NEAREST_ONLY = 1  # up to three axes where a border is narrowed, and where places are tried again
AGAIN = 3  # times at most that all places without a motion are tried again


def find_borders(growth: Growth, places: Sequence[tuple[int, Place]]) -> bool:
    """Nodes of patterns at places, (pattern, place) each, and where there is no motion the border before it.

    The way from such a place to the pattern's nearest node is halved until it is short. Returns whether the growth
    knows more than before.
    """
    known = sum(map(len, growth.nodes)) + sum(map(len, growth.infeasible))
    asked = [(sheet, place) for sheet, place in places if growth.nodes[sheet]]
    try_places(growth, asked)
    beyond = {(sheet, place): place for sheet, place in asked if place not in growth.nodes[sheet]}
    while beyond:
        middles = {at: _middle(growth, at[0], place) for at, place in beyond.items()}
        halved = [(at, middle) for at, middle in middles.items() if middle is not None]
        try_places(growth, [(sheet, middle) for (sheet, _), middle in halved], _starts_beside(growth))
        # A node in the middle is the nearest one from now on, so that the place beyond stays.
        beyond = {at: beyond[at] if middle in growth.nodes[at[0]] else middle for at, middle in halved}
    return sum(map(len, growth.nodes)) + sum(map(len, growth.infeasible)) > known


def reconsider(growth: Growth) -> int:
    """Try again where patterns were given up, from the nodes that have come nearer since; how many new nodes there are.

    Beyond a cliff of the cost a motion is found from its own side only: of 45 places at which a trot had been given up
    29 had a motion from the nodes that were there in the end.
    """
    before = sum(map(len, growth.nodes))
    for _ in range(AGAIN):
        given_up = [(sheet, place) for sheet, places in enumerate(growth.infeasible) for place in sorted(places)]
        known = sum(map(len, growth.nodes))
        left = [(sheet, place) for sheet, place in given_up if growth.nodes[sheet] and growth.inside(place)]
        try_places(growth, left, _starts_beside(growth))
        if sum(map(len, growth.nodes)) == known:
            break
        growth.spread()
    return sum(map(len, growth.nodes)) - before


def try_places(growth: Growth, places: Sequence[tuple[int, Place]], starts: int = STARTS) -> None:
    """A node of each pattern at its place, or the knowledge that there is none: by quick solves, then by careful ones.

    Near a border costs rise steeply, and there a sixth of what quick solves give up has a motion. Of 80 places over
    four axes that both had given up all had one from the nominal start, since no node led to it. With NEAREST_ONLY the
    nominal start is left out.
    """
    left = [(sheet, place) for sheet, place in dict.fromkeys(places) if place not in growth.nodes[sheet]]
    for solve in (growth.solver.nodes, growth.solver.careful_nodes):
        for start in range(starts):
            requests = [
                (sheet, place, near[start])
                for sheet, place in left
                if start < len(near := growth.nearest(sheet, place, starts))
            ]
            left = _without(growth, left, requests, solve(requests))
    if starts > NEAREST_ONLY:
        requests = [(sheet, place, growth.nominal(sheet, place)) for sheet, place in left]
        left = _without(growth, left, requests, growth.solver.careful_nodes(requests))
    for sheet, place in left:
        growth.give_up(sheet, place)


def _starts_beside(growth: Growth) -> int:
    """From how many nodes a place is tried beside one that was given up, or that one again."""
    return STARTS if growth.is_wide else NEAREST_ONLY


def _middle(growth: Growth, sheet: int, place: Place) -> Place | None:
    """The middle between a place and the pattern's nearest node; None where that is near enough."""
    nodes, asked = np.array(sorted(growth.nodes[sheet])), np.array(place)
    away = np.linalg.norm((nodes - asked) / growth.steps, axis=1)
    if away.min() <= NARROW:
        return None
    return tuple(round(float(x), DECIMALS) for x in (nodes[away.argmin()] + asked) / 2)


def _without(
    growth: Growth, left: Sequence[tuple[int, Place]], requests: Sequence[Request], found: Sequence[Node | None]
) -> list[tuple[int, Place]]:
    """Keep the nodes that were found, and return what is left without one."""
    for (sheet, _, _), node in zip(requests, found, strict=True):
        growth.keep(sheet, node)
    return [(sheet, place) for sheet, place in left if place not in growth.nodes[sheet]]
