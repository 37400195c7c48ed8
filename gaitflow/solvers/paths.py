"""Variables that move together: feet in stance, and the first and the last knot of a cycle.

A foot that stands has a position at every knot and, between each two knots, a row that says they are equal. Such a row
has a 1 and a -1, so a Newton step is the same for all variables that such rows join, except for the rows' errors.
Joined into a path they are one unknown of the KKT matrix; the variables and rows apart are twice as many as the knots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

Places = NDArray[np.intp]


@dataclass(frozen=True)
class Paths:
    """Variables joined by rows, path after path.

    nodes [n]: variables in the order of their paths; first [n]: where in `nodes` the path of each begins. joined: which
    nodes are not the first of their path; of these, in order: `rows` [n - paths], the row that joins it to the node
    before, and `signs`, the coefficient that it has there, 1 or -1; the node before has the opposite one.
    """

    nodes: Places
    first: Places
    joined: NDArray[np.bool_]
    rows: Places
    signs: Array

    def groups(self, variables: int) -> Places:
        """A number for each variable [variables], the same for all of a path; the numbers are 0, 1, 2, ..."""
        leader = np.arange(variables)
        leader[self.nodes] = self.nodes[self.first]
        return np.unique(leader, return_inverse=True)[1]

    def offsets(self, right: Array, variables: int) -> Array:
        """How much further than the first of its path each variable [variables] moves, as the rows' right sides ask."""
        apart = np.zeros(len(self.nodes))
        apart[self.joined] = self.signs * right[self.rows]
        along = np.cumsum(apart)
        offsets = np.zeros(variables)
        offsets[self.nodes] = along - along[self.first]
        return offsets

    def multipliers(self, left: Array) -> Array:
        """Multipliers of `rows` that balance what is left [variables] of the variables' equations."""
        if not len(self.nodes):
            return np.zeros(0)
        along = np.cumsum(left[self.nodes])
        ends = np.append(np.flatnonzero(~self.joined)[1:], len(self.nodes)) - 1
        path = np.cumsum(~self.joined) - 1
        from_here_on = along[ends][path] - along + left[self.nodes]
        return self.signs * from_here_on[self.joined]


def find_paths(rows: Places, variables: Places, values: Array) -> Paths:
    """The paths in the entries of a Jacobian: its rows with nothing but a 1 and a -1, at different variables.

    Entries come as (row, variable, value). A row is left out where it would close a ring or make a path branch.
    """
    order = np.argsort(rows, kind="stable")
    rows, variables, values = rows[order], variables[order], values[order]
    starts = np.flatnonzero(np.append(True, rows[1:] != rows[:-1])) if len(rows) else np.zeros(0, dtype=np.intp)
    two = starts[np.diff(np.append(starts, len(rows))) == 2]
    two = two[(values[two] == -values[two + 1]) & (np.abs(values[two]) == 1)]
    neighbours: dict[int, list[tuple[int, int, float]]] = {}
    end: dict[int, int] = {}  # of a path that ends at a variable: its other end
    for at in two:
        one, other, row, value = int(variables[at]), int(variables[at + 1]), int(rows[at]), float(values[at])
        if len(neighbours.get(one, ())) == 2 or len(neighbours.get(other, ())) == 2 or end.get(one, one) == other:
            continue
        neighbours.setdefault(one, []).append((other, row, -value))
        neighbours.setdefault(other, []).append((one, row, value))
        far, near = end.get(one, one), end.get(other, other)
        end[far], end[near] = near, far
    return _walked(neighbours)


def _walked(neighbours: dict[int, list[tuple[int, int, float]]]) -> Paths:
    """The paths of a graph without rings: of each variable its neighbours, the row between and their coefficient."""
    nodes, first, rows, signs = list[int](), list[int](), list[int](), list[float]()
    joined: list[bool] = []
    seen: set[int] = set()
    for variable in sorted(neighbours):
        if variable in seen or len(neighbours[variable]) != 1:
            continue
        begin = len(nodes)
        at, came = variable, -1
        while True:
            seen.add(at)
            nodes.append(at)
            first.append(begin)
            joined.append(came >= 0)
            onward = [each for each in neighbours[at] if each[1] != came]
            if not onward:
                break
            at, came, sign = onward[0]
            rows.append(came)
            signs.append(sign)
    return Paths(
        np.array(nodes, dtype=np.intp), np.array(first, dtype=np.intp), np.array(joined, dtype=bool),
        np.array(rows, dtype=np.intp), np.array(signs),
    )  # fmt: skip
