"""A solver of nodes whose motions end where a test says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from gaitflow.atlas.node import Node, NodeSolver, Place, Request


class Limited:
    """Finds a node wherever there is said to be a motion, and none elsewhere."""

    def __init__(self, solver: NodeSolver, node: Node, feasible: Callable[[Place], bool]) -> None:
        self.patterns, self.methods, self.from_solution = solver.patterns, solver.methods, solver.from_solution
        self._node, self._feasible = node, feasible
        self.asked: list[Place] = []

    def nodes(self, requests: Sequence[Request]) -> list[Node | None]:
        places = [place for _, place, _ in requests]
        self.asked += places
        return [replace(self._node, place=place) if self._feasible(place) else None for place in places]

    careful_nodes = nodes
