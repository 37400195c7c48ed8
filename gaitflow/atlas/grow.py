"""Growing a map's atlas from the dataset: nodes of every competitive gait at the tasks of the grid.

Seeds are the dataset's own solutions, on the grid or off it. From each node its gait spreads to the neighbouring tasks
of the grid, as long as it is nearly the cheapest there: to where it was not solved or not kept, and to where a
neighbour's motion is cheaper. A node off the grid spreads to the corners of its cell.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from gaitflow.atlas.mirror import NodeImages
from gaitflow.atlas.node import Each, Node, NodeSolver, Place, Request
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem
from gaitflow.runtime.atlas import NEAR_AXES, Atlas, Prediction
from gaitflow.search.solution import Solution
from gaitflow.search.starts import nominal

COMPETITIVE = 1.15  # a gait is seeded at, and spreads from, tasks where it costs at most this times the cheapest;
COMPETITIVE_WIDE = 1.06  # over more axes than three, where a wider band would be most of all nodes
HOPELESS = 1.15  # over more axes than three: what is predicted to cost more times the cheapest is not tried
MOST_IN_VAIN = 4  # attempts after which a gait is not tried again at a place;
MOST_IN_VAIN_WIDE = 2  # over more axes than three
CHEAPER = 1e-4  # relative: a motion that saves less is the same one
PROMISING = 0.02  # relative: what a neighbour's motion must promise to save before it is tried
DECIMALS = 9  # of the places of nodes
APART = 0.5  # in the problem's scaled variables: how far it must be from the motion that is there
AT_ONCE = 64  # nodes that are solved side by side before anyone hears how far it is


@dataclass
class Growth:
    """Nodes by pattern and place inside the domain, and the least cost that is known at each place.

    `images` makes the nodes of a pattern's mirror image from its own, where a map has them.
    """

    problem: GaitProblem
    solver: NodeSolver
    domain: Domain
    nodes: list[dict[Place, Node]] = field(init=False)
    best: dict[Place, float] = field(default_factory=dict)
    infeasible: list[set[Place]] = field(init=False)  # places where no start led to a motion, by pattern
    on_node: Callable[[int], None] = lambda nodes: None
    images: NodeImages | None = None
    _starts: list[dict[Place, Prediction]] = field(init=False)
    _fringe: deque[tuple[int, Place]] = field(default_factory=deque)
    _in_vain: Counter[tuple[int, Place]] = field(default_factory=Counter)  # attempts that led to no cheaper motion
    _planted: set[tuple[int, Place]] = field(default_factory=set)  # nodes of an earlier growth, which have spread there

    def __post_init__(self) -> None:
        self.nodes = [{} for _ in self.solver.patterns]
        self.infeasible = [set() for _ in self.solver.patterns]
        self._starts = [{} for _ in self.solver.patterns]

    @property
    def reached(self) -> Domain:
        """The tasks between those of the grid at which some gait has a node."""
        shape = self.domain.feasible.shape
        places = [any(place in nodes for nodes in self.nodes) for place in product(*self.grid)]
        return Domain(self.domain.axes, np.array(places).reshape(shape))

    @property
    def _competitive(self) -> float:
        return COMPETITIVE_WIDE if self.is_wide else COMPETITIVE

    @property
    def is_wide(self) -> bool:
        """Whether there are so many axes that nodes lie far apart, and most neighbours of a gait's where it is dear."""
        return len(self.grid) > NEAR_AXES

    @property
    def grid(self) -> tuple[tuple[float, ...], ...]:
        """The values of each axis with a range."""
        return tuple(self.domain.axes.values())

    @property
    def steps(self) -> Array:
        """The mean step [a] of the grid along each axis, 1 for an axis of one value."""
        return np.array([(axis[-1] - axis[0]) / (len(axis) - 1) if len(axis) > 1 else 1.0 for axis in self.grid])

    def inside(self, place: Place) -> bool:
        """Whether there may be nodes at a place."""
        return self.domain.contains(dict(zip(self.domain.axes, place, strict=True)))

    def numbers_of(self, atlas: Atlas) -> list[int]:
        """The numbers of the patterns of an atlas' sheets, in their order: a pattern without nodes inside has none."""
        patterns = [pattern.text for pattern in self.solver.patterns]
        return [patterns.index(sheet.pattern) for sheet in atlas.sheets]

    def extend(self, patterns: Sequence[Pattern]) -> None:
        """Take in more full patterns, numbered after those that there are."""
        self.solver.extend(patterns)
        self.nodes += [{} for _ in patterns]
        self.infeasible += [set() for _ in patterns]
        self._starts += [{} for _ in patterns]

    def keep(self, sheet: int, node: Node | None) -> bool:
        """Take a node in unless a cheaper one is there; True when it was."""
        if node is None:
            return False
        known = self.nodes[sheet].get(node.place)
        if known is not None and node.cost >= known.cost * (1 - CHEAPER):
            return False
        self._store(sheet, node)
        self._fringe.append((sheet, node.place))
        self._store_image(sheet, node)
        self.on_node(sum(map(len, self.nodes)))
        return True

    def plant(self, sheet: int, node: Node) -> None:
        """Take in a node of an earlier growth, and its image: they have spread there, and are not sown again."""
        self._store(sheet, node)
        self._store_image(sheet, node)
        self._planted.add((sheet, node.place))
        if self.images is not None:
            other = self.image_of(sheet)
            self._planted.add((sheet if other is None else other, self.images.place(node.place)))
        self.on_node(sum(map(len, self.nodes)))

    def _store(self, sheet: int, node: Node) -> None:
        self.nodes[sheet][node.place] = node
        self.infeasible[sheet].discard(node.place)
        self.best[node.place] = min(node.cost, self.best.get(node.place, np.inf))

    def _store_image(self, sheet: int, node: Node) -> None:
        """Store a node's image, if that is of another pattern that there is: it spreads as the node does."""
        if self.images is None:
            return
        patterns, methods, other = self.solver.patterns, self.solver.methods, self.image_of(sheet)
        if other is None:
            return
        found = self.images.node(node, patterns[sheet], methods[sheet].space, methods[other].space)
        known = self.nodes[other].get(found.place)
        if self.inside(found.place) and (known is None or found.cost < known.cost * (1 - CHEAPER)):
            self._store(other, found)

    def image_of(self, sheet: int) -> int | None:
        """The pattern that is the mirror image of another one; None without images, or where it is that one itself."""
        patterns = self.solver.patterns
        image = patterns[sheet] if self.images is None else self.images.pattern(patterns[sheet])
        return patterns.index(image) if image != patterns[sheet] and image in patterns else None

    def give_up(self, sheet: int, place: Place) -> None:
        """Take it that a pattern has no motion at a place, where it has no node, nor its image at that of the place."""
        self._note_infeasible(sheet, place)
        other = self.image_of(sheet)
        if self.images is not None:
            self._note_infeasible(sheet if other is None else other, self.images.place(place))

    def _note_infeasible(self, sheet: int, place: Place) -> None:
        if place not in self.nodes[sheet] and self.inside(place):
            self.infeasible[sheet].add(place)

    def infeasible_places(self, sheet: int) -> Array:
        """Where a pattern has no motion [m, a], in their order."""
        return np.array(sorted(self.infeasible[sheet]), dtype=float).reshape(-1, len(self.grid))

    def sow(self, solutions: Iterable[Solution]) -> None:
        """Nodes from the solved tasks that are not held out, where a pattern is competitive."""
        index = {pattern.text: sheet for sheet, pattern in enumerate(self.solver.patterns)}
        problem, axes = self.problem, tuple(self.domain.axes)
        costs: dict[tuple[int, Place], float] = {}
        for one in solutions:
            place = one.task.on(axes)
            if one.task.split == "held_out" or one.status != "solved" or not one.cost > 0 or not self.inside(place):
                continue
            cost = one.cost / problem.cost_scale
            self.best[place] = min(cost, self.best.get(place, np.inf))
            sheet = index.get(one.pattern)
            if sheet is None or one.trajectory is None or one.multipliers is None:
                continue
            if cost < costs.get((sheet, place), np.inf):
                costs[sheet, place] = cost
                w = problem.layout.pack(one.trajectory, one.task.cycle_duration, one.pattern)
                start = self.solver.from_solution(sheet, w, one.multipliers.bounds, one.multipliers.rows, cost)
                self._starts[sheet][place] = start
        competitive = [
            (sheet, place, self._starts[sheet][place])
            for (sheet, place), cost in sorted(costs.items(), key=lambda item: (item[1], item[0]))
            if cost <= self._competitive * self.best[place] and self._is_news(sheet, place, cost)
        ]
        self._solve(competitive)

    def _is_news(self, sheet: int, place: Place, cost: float) -> bool:
        """Whether a solution's cost is of another motion than the planted node there, if there is one."""
        known = self.nodes[sheet].get(place)
        return (sheet, place) not in self._planted or known is None or cost < known.cost * (1 - CHEAPER)

    def start_at(self, sheet: int, place: Place) -> Prediction | None:
        """The dataset's own solution of a sheet at a place; None without one."""
        return self._starts[sheet].get(place)

    def nearest(self, sheet: int, place: Place, count: int) -> list[Prediction]:
        """First-order predictions at a place from the `count` nodes of a sheet that are nearest to it."""
        nodes = list(self.nodes[sheet].values())
        places = np.array([node.place for node in nodes]).reshape(len(nodes), len(self.grid))
        distances = np.linalg.norm((places - np.array(place)) / self.steps, axis=1)
        near = np.lexsort((*places.T[::-1], distances))[:count]  # of equally distant ones the first place
        return [nodes[number].moved(place) for number in near]

    def nominal(self, sheet: int, place: Place) -> Prediction:
        """The start of a search at a place, for the cost that the nearest node promises there; no node leads to it."""
        scenario, layout = self.problem.scenario, self.problem.layout
        task = scenario.tasks.space.task(dict(zip(self.domain.axes, place, strict=True)))
        w, [near] = nominal(scenario.robot, layout, task), self.nearest(sheet, place, 1)
        return self.solver.from_solution(sheet, w, np.zeros(layout.nw), np.zeros(self.problem.ng), near.cost)

    def neighbours(self, place: Place) -> list[Place]:
        """The places one step of the grid away that are inside; of a place off the grid the corners of its cell."""
        if any(value not in values for value, values in zip(place, self.grid, strict=True)):
            corners = product(*(around(values, value) for value, values in zip(place, self.grid, strict=True)))
            return [corner for corner in corners if self.inside(corner)]
        found = []
        for axis, values in enumerate(self.grid):
            at = values.index(place[axis])
            found += [(*place[:axis], values[i], *place[axis + 1 :]) for i in (at + 1, at - 1) if 0 <= i < len(values)]
        return [near for near in found if self.inside(near)]

    def spread(self) -> None:
        """Solve neighbours, all patterns one step at a time, until nothing new is competitive."""
        tried: set[tuple[int, Place, Place, float]] = set()
        while self._fringe:
            targets = self._targets(tried)
            for turn in range(max(map(len, targets.values()), default=0)):
                self._try(
                    [(sheet, beside[turn], near) for (sheet, near), beside in targets.items() if turn < len(beside)]
                )

    def _targets(self, tried: set[tuple[int, Place, Place, float]]) -> dict[tuple[int, Place], list[Node]]:
        """Where patterns may spread, and from which of the nodes that are new since the last time."""
        targets: dict[tuple[int, Place], list[Node]] = {}
        while self._fringe:
            sheet, place = self._fringe.popleft()
            node = self.nodes[sheet][place]
            if node.cost > self._competitive * self.best[place]:
                continue
            for near in self.neighbours(place):
                attempt = sheet, place, near, node.cost
                if attempt not in tried:
                    tried.add(attempt)
                    targets.setdefault((sheet, near), []).append(node)
        return targets

    def _try(self, attempts: Sequence[tuple[int, Node, Place]]) -> None:
        """Nodes at places beside others, by their tangents, and first of all from the dataset's own solutions."""
        self._solve(
            [
                (sheet, near, self._starts[sheet][near])
                for sheet, _, near in attempts
                if near not in self.nodes[sheet] and near in self._starts[sheet]
            ]
        )
        by_tangents = [(sheet, near, node.moved(near)) for sheet, node, near in attempts]
        if self.is_wide:
            by_tangents.sort(key=lambda request: request[2].cost)  # so that the cheapest of each place is known first
        self._solve(by_tangents, self._promises)

    def _solve(self, requests: Sequence[Request], wanted: Callable[[Request], bool] = lambda request: True) -> None:
        """Keep the nodes that requests lead to, of those that are still `wanted` when it is their turn."""
        left = deque(requests)
        while left:
            batch = list[Request]()
            while left and len(batch) < AT_ONCE:
                request = left.popleft()
                if wanted(request):
                    batch.append(request)
            for (sheet, place, _), node in zip(batch, self.solver.nodes(batch), strict=True):
                if not self.keep(sheet, node):
                    self._in_vain[sheet, place] += 1

    def _promises(self, request: Request) -> bool:
        """Whether a prediction is of another motion than the one that is known there, if any, and of a cheaper one."""
        sheet, place, predicted = request
        if self._in_vain[sheet, place] >= (MOST_IN_VAIN_WIDE if self.is_wide else MOST_IN_VAIN):
            return False
        if self.is_wide and predicted.cost > HOPELESS * self.best.get(place, np.inf):
            return False
        known = self.nodes[sheet].get(place)
        if known is None:
            return True
        free = len(self.solver.methods[sheet].space.free)
        apart = np.abs(predicted.point[:free] - known.point[:free]).max()
        return bool(predicted.cost < known.cost * (1 - PROMISING) and apart > APART)


def around(values: Sequence[float], value: float) -> tuple[float, ...]:
    """The values of an axis next to one within its range: that value itself where the axis has it, else two."""
    at = bisect_left(values, value)
    return (value,) if value == values[at] else (values[at - 1], values[at])


def grow(
    problem: GaitProblem,
    patterns: Sequence[Pattern],
    solutions: Iterable[Solution],
    domain: Domain,
    on_node: Callable[[int], None] = lambda nodes: None,
    each: Each | None = None,
) -> Growth:
    """Nodes of patterns at the tasks of the grid inside the domain; equal arguments, equal nodes.

    `on_node` hears how many nodes there are; `each` solves several at once, see `NodeSolver`.
    """
    growth = Growth(problem, NodeSolver(problem, patterns, each), domain, on_node=on_node)
    growth.sow(solutions)
    growth.spread()
    return growth
