"""Growing a map's atlas: from the dataset's solutions to solved tasks of every gait, as dense as a start needs them.

From the tasks of the dataset each gait spreads to neighbouring nodes, each solved from the one beside it, as long as it
is nearly the cheapest there. A neighbour that finds a cheaper motion of a gait replaces the one that was found before:
so better local optima spread, too.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem
from gaitflow.search.solution import Multipliers, Solution
from gaitflow.solvers.interior_point import InteriorPoint, Outcome
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start
from gaitflow.solvers.point import GaitSpace, Point
from gaitflow.solvers.program import Program, derivatives

REFINE = 4  # nodes per step of the map's grid
BARRIER = 1e-4  # of the nodes: small enough to be near the optimum, large enough to feel a bound before it is met
COMPETITIVE = 1.15  # a gait spreads from nodes where it costs at most this times the cheapest
CHEAPER = 1e-4  # relative
FAR = 2.0  # in the problem's scaled variables: neighbours further apart belong to different motions
ITERATIONS = 25

Place = tuple[int, int]


@dataclass(frozen=True)
class Node:
    """One gait at one task: the cost of its optimum, the problem's, and its point on the central path."""

    cost: float
    point: Point


@dataclass(frozen=True)
class Grown:
    """All nodes by pattern, in the patterns' order, on the axes speed [m/s] and cycle duration [s]; and the solves."""

    patterns: tuple[Pattern, ...]
    speeds: tuple[float, ...]
    cycle_durations: tuple[float, ...]
    methods: tuple[InteriorPoint, ...]
    nodes: tuple[dict[Place, Node], ...]
    solves: int


def grow(
    problem: GaitProblem,
    patterns: Sequence[Pattern],
    solutions: Iterable[Solution],
    inside: Callable[[float, float], bool],
    on_node: Callable[[int], None] = lambda nodes: None,
) -> Grown:
    """Nodes for full patterns, seeded by the solved grid tasks among `solutions`, at tasks that are `inside`.

    `on_node` hears how many nodes there are. Equal arguments give equal nodes.
    """
    growth = _Growth(problem, patterns, inside)
    index = {pattern.text: gait for gait, pattern in enumerate(patterns)}
    seeds = sorted(
        (one for one in solutions if one.pattern in index and one.split == "grid" and one.status == "solved"),
        key=lambda one: (one.cost, one.pattern, one.speed, one.cycle_duration),
    )
    for seed in seeds:
        growth.sow(index[seed.pattern], seed)
    growth.spread(on_node)
    return Grown(tuple(patterns), growth.speeds, growth.durations, growth.methods, tuple(growth.nodes), growth.solves)


def finer(values: Sequence[float]) -> tuple[float, ...]:
    """An axis with REFINE steps for each of `values`'; a single value gets a neighbour, at which there are no nodes."""
    if len(values) == 1:
        return (values[0], values[0] + 1.0)
    coarse = np.arange(len(values)) * REFINE
    return tuple(round(float(x), 9) for x in np.interp(np.arange(coarse[-1] + 1), coarse, values))


@dataclass
class _Growth:
    problem: GaitProblem
    patterns: Sequence[Pattern]
    inside: Callable[[float, float], bool]
    solves: int = 0
    fringe: deque[tuple[int, Place]] = field(default_factory=deque)

    def __post_init__(self) -> None:
        tasks = self.problem.scenario.tasks
        self.speeds, self.durations = finer(tasks.speed.values), finer(tasks.cycle_duration.values)
        self.scenario = self.problem.scenario.as_data()
        program = Program(self.problem.nlp, derivatives(self.problem.nlp))
        bounds = [self.problem.bounds(pattern) for pattern in self.patterns]
        self.methods = tuple(
            InteriorPoint(program, GaitSpace(each.lower, each.upper, each.lower_rows, each.upper_rows))
            for each in bounds
        )
        self.ipopt = FixedGaitSolver(self.problem, self.problem.scenario.strategy.solve_time_limit)
        self.nodes: list[dict[Place, Node]] = [{} for _ in self.patterns]
        self.best: dict[Place, float] = {}

    def sow(self, gait: int, seed: Solution) -> None:
        """A node from a solution of the dataset, if its trajectory and multipliers were kept."""
        if seed.trajectory is None or seed.multipliers is None:
            return
        place = self.speeds.index(round(seed.speed, 9)), self.durations.index(round(seed.cycle_duration, 9))
        cost = seed.cost / self.problem.cost_scale
        w = self.problem.layout.pack(seed.trajectory, seed.cycle_duration)
        start = self.methods[gait].space.split(w, seed.multipliers.bounds, seed.multipliers.rows, cost)
        self._keep(gait, place, self._solved(gait, place, Node(cost, start)))

    def spread(self, on_node: Callable[[int], None]) -> None:
        """Solve neighbours, all gaits one step at a time, until nothing new is worth it.

        Every task of the dataset is a node of its cheapest gait, so what is worth it is known a few steps from there.
        """
        tried: set[tuple[int, Place, Place, float]] = set()
        while self.fringe:
            gait, place = self.fringe.popleft()
            node = self.nodes[gait][place]
            if node.cost > COMPETITIVE * self.best[place]:
                continue
            for near in self._neighbours(place):
                known = self.nodes[gait].get(near)
                attempt = gait, place, near, node.cost
                if attempt in tried or (known and _apart(known.point, node.point) < FAR):
                    continue
                tried.add(attempt)
                found = self._solved(gait, near, Node(known.cost if known else node.cost, node.point))
                if found and (known is None or found.cost < known.cost * (1 - CHEAPER)):
                    self._keep(gait, near, found)
            on_node(sum(map(len, self.nodes)))

    def _neighbours(self, place: Place) -> list[Place]:
        i, j = place
        around = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]
        return [
            (a, b)
            for a, b in around
            if 0 <= a < len(self.speeds) and 0 <= b < len(self.durations)
            if self.inside(self.speeds[a], self.durations[b])
        ]

    def _keep(self, gait: int, place: Place, node: Node | None) -> None:
        if node is None or (place in self.nodes[gait] and self.nodes[gait][place].cost <= node.cost):
            return
        self.nodes[gait][place] = node
        self.best[place] = min(node.cost, self.best.get(place, np.inf))
        self.fringe.append((gait, place))

    def _solved(self, gait: int, place: Place, start: Node) -> Node | None:
        """A node from a start nearby: along the central path, to the optimum, checked, and back for the right unit."""
        self.solves += 1
        task = np.array([self.speeds[place[0]], self.durations[place[1]]])
        method = self.methods[gait]
        near = method.centre(task, start.point, start.cost, BARRIER, ITERATIONS)
        if near.converged:
            optimum = method.follow(task, near.point, start.cost, BARRIER, ITERATIONS)
            if optimum.converged and optimum.cost > 0 and self._feasible(gait, task, optimum):
                found: Node | None = Node(optimum.cost, _scaled(near.point, start.cost / optimum.cost))
            else:
                found = self._by_ipopt(gait, task, Node(start.cost, near.point))
        elif self.best.get(place, np.inf) > COMPETITIVE * start.cost:  # worth more effort: nothing else is as cheap
            found = self._by_ipopt(gait, task, start)
        else:
            return None
        if found is None or found.cost <= 0:
            return None
        centred = method.centre(task, found.point, found.cost, BARRIER, ITERATIONS)
        return Node(found.cost, centred.point) if centred.converged else None

    def _feasible(self, gait: int, task: Array, optimum: Outcome) -> bool:
        speed, duration = float(task[0]), float(task[1])
        trajectory = self.problem.layout.unpack(optimum.w, duration)
        return check.worst(self.scenario, trajectory, speed, duration, self.patterns[gait].text) <= check.FEASIBLE

    def _by_ipopt(self, gait: int, task: Array, start: Node) -> Node | None:
        """The optimum that IPOPT finds from a start."""
        space = self.methods[gait].space
        primal, bounds, rows = space.join(start.point, start.cost)
        begin = Start("neighbour", primal, Multipliers(bounds, rows))
        found = self.ipopt.solve(self.patterns[gait], float(task[0]), float(task[1]), begin)
        if not found.feasible:
            return None
        cost = found.cost / self.problem.cost_scale
        return Node(cost, space.split(found.w, found.multipliers.bounds, found.multipliers.rows, cost))


def _scaled(point: Point, factor: float) -> Point:
    """The point for another unit of the cost."""
    return Point(point.free, point.rows * factor, point.lower * factor, point.upper * factor)


def _apart(one: Point, other: Point) -> float:
    return float(np.abs(one.free - other.free).max())
