"""Where the atlas predicts badly between its nodes: kinks, cliffs and borders of gaits get nodes of their own.

The centres of the grid's cells are tested. Where a test fails, a node is added, and the parts of the cell are tested
next, those of the worst cells first. Of a cell and its mirror image one is tested, where nodes have images. Over more
axes than three, where plans take the nominal start, a test is of costs alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from gaitflow.atlas.border import find_borders
from gaitflow.atlas.grow import AT_ONCE, DECIMALS, Growth
from gaitflow.atlas.node import Node, Place, Request
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, Prediction

ROUNDS = 3
MOST_TESTS = 1000  # on two axes
FURTHER_AXIS = 3  # times as many on three axes and more
FEWER_WIDE = 2  # times fewer over more axes than three, where a test that fails has most neighbours to spread to
FEWER_OF_ENERGY = 3  # times fewer: energy's derivatives take three times as long
GOOD = 8  # iterations that a prediction may need
LIMIT = 18  # iterations beyond which a prediction led nowhere
WRONG = 0.02  # relative error of a predicted cost that is not good
LEAST_ERROR = 1e-6  # of what took too many iterations
RIVAL = 1.1  # times the least predicted cost: what may cost less might be the cheapest
RIVALS = 4


@dataclass(frozen=True)
class Found:
    """What a test found: the problem's cost, the iterations from a prediction, and the node if one was made."""

    cost: float
    iterations: int
    node: Node | None = None


@dataclass(frozen=True)
class Cell:
    """A box of tasks: its centre and half of its widths [a]."""

    centre: Place
    half: tuple[float, ...]

    def parts(self) -> list[Cell]:
        """The 2^a boxes of half the size; an axis without width is not cut."""
        half = tuple(width / 2 for width in self.half)
        sides = [(-1, 1) if width else (0,) for width in half]
        return [
            Cell(tuple(round(x + s * w, DECIMALS) for x, s, w in zip(self.centre, signs, half, strict=True)), half)
            for signs in product(*sides)
        ]


def fill(
    growth: Growth,
    compiled: Callable[[], Atlas],
    tie_tolerance: float,
    rounds: int = ROUNDS,
    on_test: Callable[[int, int], None] = lambda done, most: None,
) -> None:
    """Add nodes where tests fail; `compiled` makes the atlas of the nodes that there are, its sheets in their order.

    `on_test` hears how many tests are done, and how many there will be if as many fail as did so far.
    """
    cells, left = _cells(growth), MOST_TESTS * (FURTHER_AXIS if len(growth.grid) > 2 else 1)
    if growth.is_wide:
        left //= FEWER_WIDE
    if growth.problem.scenario.objective.energy:
        left //= FEWER_OF_ENERGY
    if growth.images is not None:
        left //= 2  # each tells as much of its image
    done = 0
    for number in range(rounds):
        atlas = compiled()
        sheets = growth.numbers_of(atlas)
        wrong = list[tuple[Cell, float]]()
        left -= len(cells)
        for first in range(0, len(cells), AT_ONCE):
            batch = cells[first : first + AT_ONCE]
            errors = _errors(growth, atlas, sheets, [cell.centre for cell in batch], tie_tolerance)
            wrong += [(cell, error) for cell, error in zip(batch, errors, strict=True) if error]
            tested, parts = first + len(batch), len(batch[-1].parts())
            further = _foretold(len(cells), len(wrong) / tested * parts, rounds - number - 1, left)
            on_test(done + tested, done + len(cells) + further)
        done += len(cells)
        growth.spread()
        worst = sorted(wrong, key=lambda each: -each[1])
        cells = _one_of_images(growth, [part for cell, _ in worst for part in cell.parts()])[:left]
        if not cells:
            return


def _foretold(cells: int, growth: float, rounds: int, most: int) -> int:
    """Tests in some more rounds of which each has `growth` times as many as the one before."""
    return min(most, round(sum(cells * growth**number for number in range(1, rounds + 1))))


def _cells(growth: Growth) -> list[Cell]:
    """The cells of the grid all of whose corners are inside; along an axis of one value they have no width."""
    ends = [list(pairwise(axis)) or [(axis[0], axis[0])] for axis in growth.grid]
    boxes = [
        Cell(
            tuple(round((low + high) / 2, DECIMALS) for low, high in box),
            tuple((high - low) / 2 for low, high in box),
        )
        for box in product(*ends)
    ]
    return _one_of_images(growth, [cell for cell in boxes if any(cell.half) and growth.inside(cell.centre)])


def _one_of_images(growth: Growth, cells: Sequence[Cell]) -> list[Cell]:
    """The cells without the mirror images of others, where nodes have images."""
    images = growth.images
    return [cell for cell in cells if images is None or cell.centre <= images.place(cell.centre)]


def _errors(
    growth: Growth, atlas: Atlas, sheets: Sequence[int], places: Sequence[Place], tie_tolerance: float
) -> list[float]:
    """How wrong the atlas is at places: the relative error of a cost, infinite where a start led nowhere, 0 if good.

    Where it is not good the gaits that may be the cheapest get nodes there.
    """
    rivals = [_rivals(atlas, np.array(place)) for place in places]
    predicted = [
        {rival: _predicted(atlas, rival, place) for rival in each}
        for (_, each), place in zip(rivals, places, strict=True)
    ]
    asked = [(number, rival) for number, each in enumerate(predicted) for rival in each]
    starts = [(sheets[rival], places[number], predicted[number][rival]) for number, rival in asked]
    found: list[dict[int, Found]] = [{} for _ in places]
    for (number, rival), tested in zip(asked, _tested(growth, starts), strict=True):
        if tested is not None:
            found[number][rival] = tested
    errors = [
        _error(first, known, each, tie_tolerance)
        for (first, _), known, each in zip(rivals, predicted, found, strict=True)
    ]
    wrong = [(number, rival, found[number].get(rival)) for number, rival in asked if errors[number]]
    unsolved = [
        (rival, places[number])
        for number, rival, one in wrong
        if one is None or not growth.keep(sheets[rival], one.node)
    ]
    _add(growth, atlas, sheets, unsolved)
    return errors


def _tested(growth: Growth, starts: Sequence[Request]) -> list[Found | None]:
    """What predictions lead to, and over many axes what the nominal start does; None where it is no motion."""
    if growth.is_wide:
        requests = [(sheet, place, growth.nominal(sheet, place)) for sheet, place, _ in starts]
        nodes = growth.solver.careful_nodes(requests)
        return [None if node is None else Found(node.cost, 0, node) for node in nodes]
    outcomes = growth.solver.refinements(starts, LIMIT)
    return [Found(one.cost, one.iterations) if one.converged and one.cost > 0 else None for one in outcomes]


def _predicted(atlas: Atlas, rival: int, place: Place) -> Prediction:
    predicted = atlas.predict(rival, np.array(place))
    assert predicted is not None, "a ranked sheet has a node within reach"
    return predicted


def _error(first: int, predicted: Mapping[int, Prediction], found: Mapping[int, Found], tie_tolerance: float) -> float:
    """How wrong the predicted costs of rivals are at a place, given what was found there; `first` is the pick."""
    if first not in found:
        return float("inf")
    chosen = found[first]
    off = abs(predicted[first].cost / chosen.cost - 1)
    regret = chosen.cost / min(one.cost for one in found.values()) - 1
    good = off <= WRONG and chosen.iterations <= GOOD and regret <= tie_tolerance
    return 0.0 if good else float(max(off, regret, LEAST_ERROR))


def _rivals(atlas: Atlas, asked: Array) -> tuple[int, list[int]]:
    """The sheet that is predicted to cost least, and the few that might cost less."""
    ranked = atlas.ranked(asked)
    if not ranked:
        return -1, []
    costs, _ = atlas.costs(asked)
    least = np.fmin(costs, atlas.least_costs(asked))  # as a plan doubts them; where that is infinite, as predicted
    by_cost = [sheet for sheet in atlas.by_cost(asked) if least[sheet] <= RIVAL * costs[ranked[0]]]
    return ranked[0], list(dict.fromkeys([ranked[0], *by_cost]))[:RIVALS]


def _add(growth: Growth, atlas: Atlas, sheets: Sequence[int], wrong: Sequence[tuple[int, Place]]) -> None:
    """Nodes of sheets at places, (sheet, place) each, from its prediction or else from the nearest nodes.

    Where none leads to a motion there is none, and its border is looked for.
    """
    starts = {
        (rival, place): [atlas.predict(rival, np.array(place)), *atlas.nearest(rival, np.array(place), 2)]
        for rival, place in wrong
    }
    for attempt in range(max(map(len, starts.values()), default=0)):
        left = {at: each for at, each in starts.items() if attempt < len(each)}
        requests = [
            (sheets[rival], place, start)
            for (rival, place), each in left.items()
            if (start := each[attempt]) is not None
        ]
        nodes = growth.solver.nodes(requests)
        kept = {
            (sheet, place) for (sheet, place, _), node in zip(requests, nodes, strict=True) if growth.keep(sheet, node)
        }
        starts = {(rival, place): each for (rival, place), each in left.items() if (sheets[rival], place) not in kept}
    find_borders(growth, [(sheets[rival], place) for rival, place in starts])
