"""The nodes of a published map solved again, for a map that is made from more searches of the same problem.

A published atlas keeps of a node's point what its modes hold. From there nearly every node is found again in a few
iterations: 59 of 60 of `anymal-omni`, at costs that differ by 4e-6 at most. A growth solves far more than its nodes,
since most of what it tries is in vain.
"""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from gaitflow.atlas.grow import AT_ONCE, Growth
from gaitflow.atlas.node import Place, Request
from gaitflow.runtime.atlas import Atlas


def replant(growth: Growth, atlas: Atlas, patterns: Container[str]) -> int:
    """Solve the nodes again that an earlier atlas has of some of the growth's patterns; returns how many are found.

    They count as spread, as they have when the atlas was made. Where it says that a pattern has no motion, that is
    taken over. Nodes that are not found again are left to the growth. Raises ValueError where the atlas is of another
    problem.
    """
    numbers = {pattern.text: number for number, pattern in enumerate(growth.solver.patterns)}
    found = 0
    for sheet, earlier in enumerate(atlas.sheets):
        number = numbers.get(earlier.pattern)
        if number is None or earlier.pattern not in patterns:
            continue
        if not np.array_equal(growth.solver.methods[number].space.free, earlier.space.free):
            raise ValueError(f"the earlier map's pattern {earlier.pattern} leaves other variables free than this one's")
        places = [place for place in map(_place, earlier.tasks) if growth.inside(place)]
        for first in range(0, len(places), AT_ONCE):
            requests: list[Request] = [
                (number, place, atlas.nearest(sheet, np.array(place), 1)[0])
                for place in places[first : first + AT_ONCE]
                if place not in growth.nodes[number]  # it may have come as an image
            ]
            found += _solved(growth, requests)
        for place in map(_place, earlier.infeasible):
            growth.give_up(number, place)
    return found


def _solved(growth: Growth, requests: list[Request]) -> int:
    """Plant what requests lead to, by quick solves and then by careful ones; how many nodes that are."""
    before = len(requests)
    for solve in (growth.solver.nodes, growth.solver.careful_nodes):
        nodes = solve(requests)
        for (number, _, _), node in zip(requests, nodes, strict=True):
            if node is not None:
                growth.plant(number, node)
        requests = [request for request, node in zip(requests, nodes, strict=True) if node is None]
    return before - len(requests)


def _place(task: np.ndarray) -> Place:
    return tuple(task.tolist())
