"""From grown nodes to the atlas that is published: points and tangents along the modes that matter most.

Points of the central path are condensed first, which leaves half of their numbers. Every pattern has modes of its own.
Those that explain most of all nodes are kept, over all patterns at once, until the atlas has the size that it may have.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import BARRIER, Node
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.runtime.atlas_file import ROUNDED_ALONG
from gaitflow.runtime.condensed import Condenser
from gaitflow.runtime.fixed_point import rounded
from gaitflow.runtime.nearby import REACH
from gaitflow.runtime.sheet_image import imaged, signs_of

LARGEST = {2: 2_700_000, 3: 6_500_000}  # bytes of an atlas of two axes, in the plane and in space
FURTHER_AXIS = 3.9  # times as many, for each axis beyond two,
MOST_BYTES = 16_000_000  # up to here, whatever the axes: with warm starts of 60 gaits a map has 20 MB at the most
MOST_MODES = 128  # of a pattern
MANY_ROWS = 1000  # of nodes and tangents; an exact decomposition of more takes minutes in space
PASSES = 3  # over all rows, until their leading directions are found
OF_NUMBER = 2  # bytes, in fixed point
NAMES = 2600  # bytes of the names and shapes of a pattern's arrays
# What an error of a prediction counts: Newton's method finds the multipliers of rows by itself in its first step, and a
# bound's multiplier, whose logarithm is predicted, may be off by half, but a variable should not cross its bound.
OF_VARIABLES, OF_ROWS, OF_BOUNDS = 100.0, 0.1, 1.0
STRAY = 30.0  # times the usual distance of neighbours
TEAR = 4.0  # times the usual distance of neighbours' predictions half-way between them
FAR = 0.5  # steps from every node: places without a motion that no node is near
BESIDE = 1.01  # steps: nodes that are further apart are no neighbours


def build_atlas(growth: Growth, gaits: Sequence[int], largest: int | None = None) -> Atlas:
    """The atlas of the growth's nodes, of at most `largest` bytes or little more where even few modes need more.

    `gaits` are the numbers of the gaits that its patterns realise. Nodes outside the growth's domain are left out, and
    patterns without a node have no sheet. Equal nodes give an equal atlas.
    """
    inside = _inside(growth)
    images = {number: other for number in inside if (other := _first_image(growth, number, inside)) is not None}
    sheets = {number: _analysed(growth, number, inside[number]) for number in inside if number not in images}
    if largest is None:
        further = FURTHER_AXIS ** max(len(growth.domain.axes) - 2, 0)
        largest = min(int(LARGEST[growth.problem.layout.dimension] * further), MOST_BYTES)
    of_images = sum(sheets[other].image_bytes for other in images.values())
    counts = _mode_counts(list(sheets.values()), largest - of_images)
    built = {
        number: _sheet(growth, number, inside[number], gaits[number], sheet, count)
        for (number, sheet), count in zip(sheets.items(), counts, strict=True)
    }
    built |= {number: _image(growth, number, gaits[number], built[other]) for number, other in images.items()}
    return Atlas(tuple(growth.domain.axes), growth.steps, BARRIER, tuple(built[number] for number in inside))


def _inside(growth: Growth) -> dict[int, list[Node]]:
    """The nodes of each pattern that has some inside the growth's domain, by their places."""
    inside = {
        number: [nodes[place] for place in sorted(nodes) if growth.inside(place)]
        for number, nodes in enumerate(growth.nodes)
    }
    return {number: nodes for number, nodes in inside.items() if nodes}


def _first_image(growth: Growth, number: int, inside: Container[int]) -> int | None:
    """The pattern before this one of which it is the mirror image, if there is one that has nodes inside."""
    other = growth.image_of(number)
    return other if other is not None and other < number and other in inside else None


def _image(growth: Growth, number: int, gait: int, other: Sheet) -> Sheet:
    assert growth.images is not None
    space = growth.solver.methods[number].space
    image = growth.images.sheet(other.pattern, other.space, space)
    pattern = growth.solver.patterns[number].text
    return imaged(other, image, gait, pattern, space, signs_of(tuple(growth.domain.axes)))


def cost_atlas(growth: Growth, gaits: Sequence[int]) -> Atlas:
    """An atlas of the growth's nodes that predicts costs and no points: without modes it is made at once."""
    sheets = []
    for number, nodes in enumerate(growth.nodes):
        ordered = [nodes[place] for place in sorted(nodes)]
        if ordered:
            places, size = np.array([node.place for node in ordered]), len(ordered[0].point)
            sheets.append(
                Sheet(
                    gait=gaits[number],
                    pattern=growth.solver.patterns[number].text,
                    space=growth.solver.methods[number].space,
                    tasks=places,
                    costs=np.array([node.cost for node in ordered]),
                    slopes=np.array([node.slopes for node in ordered]),
                    mean=np.zeros(size, dtype=np.float32),
                    modes=np.zeros((0, size), dtype=np.float32),
                    coordinates=np.zeros((len(ordered), 0), dtype=np.float32),
                    tangents=np.zeros((*places.shape, 0), dtype=np.float32),
                    tear=0.0,
                    infeasible=_beyond(growth, number, ordered),
                )
            )
    return Atlas(tuple(growth.domain.axes), growth.steps, BARRIER, tuple(sheets))


@dataclass(frozen=True)
class _Analysed:
    """A pattern's nodes in condensed, weighted numbers: points [n, c], tangents [n, a, c], all their modes [m, c].

    sizes [m]: what each mode explains of the squares of all nodes, largest first. beyond [i, a]: where the pattern
    has no motion. kept: the bytes that impose the pattern and say where that is.
    """

    places: Array
    pairs: NDArray[np.intp]
    weights: Array
    mean: Array
    points: Array
    tangents: Array
    modes: Array
    sizes: Array
    beyond: Array
    kept: int

    @property
    def mode_bytes(self) -> int:
        """What one more mode takes: its own numbers, a coordinate and tangents of every node, and their exponents."""
        return OF_NUMBER * (len(self.weights) + len(self.places) + self.places.size + self.places.shape[1] + 1)

    @property
    def image_bytes(self) -> int:
        """What the mirror image of a pattern takes: its bounds, and of each number where it goes and its sign."""
        return self.kept + 5 * len(self.weights) + NAMES

    @property
    def other_bytes(self) -> int:
        """What is there without any mode: what is kept, mean, exponents, each node's place, cost and slopes; names."""
        of_nodes = 8 * (2 * self.places.size + len(self.places))
        return self.kept + (4 + OF_NUMBER) * len(self.weights) + of_nodes + NAMES


def _analysed(growth: Growth, number: int, nodes: Sequence[Node]) -> _Analysed:
    space = growth.solver.methods[number].space
    condenser = Condenser(space, BARRIER)
    places = np.array([node.place for node in nodes])
    pairs = _pairs(places / growth.steps)
    weights = np.repeat([OF_VARIABLES, OF_ROWS, OF_BOUNDS], condenser.kinds)
    points = np.array([condenser.condensed(node.point) for node in nodes]) * weights
    tangents = np.array([condenser.condensed(node.tangents) for node in nodes]) * weights
    points, tangents = _without_strays(pairs, points, tangents)
    mean = points.mean(axis=0)
    points -= mean
    modes, sizes = _modes(points, tangents * growth.steps[:, None])
    beyond = _beyond(growth, number, nodes)
    kept = 2 * (len(space.lower) + len(space.lower_rows)) + 8 * beyond.size  # of a bound a byte says which level
    return _Analysed(places, pairs, weights, mean, points, tangents, modes, sizes, beyond, kept)


def _modes(points: Array, tangents: Array) -> tuple[Array, Array]:
    """The directions [m, ny] in which points [n, ny] and their changes over half a step [n, a, ny] vary; how much."""
    rows = np.concatenate([points, tangents.reshape(-1, points.shape[1]) / 2])
    if len(rows) > MANY_ROWS:
        rows = _sketched(rows)
    # The rows are mostly fewer than the numbers: their products are a smaller problem than an SVD of all.
    sizes, mixtures = np.linalg.eigh(rows @ rows.T)
    kept = np.flatnonzero(sizes > 1e-12 * max(sizes[-1], 1e-300))[::-1][:MOST_MODES]
    if not len(kept):  # one node that nothing changes
        return np.eye(1, points.shape[1]), np.zeros(1)
    vectors = (mixtures[:, kept] / np.sqrt(sizes[kept])).T @ rows
    signs = np.sign(vectors[np.arange(len(vectors)), np.abs(vectors).argmax(axis=1)])
    return vectors * signs[:, None], sizes[kept]


def _sketched(rows: Array) -> Array:
    """Fewer rows that vary in about the same directions, and as much: a randomised range (Halko et al., 2011)."""
    sample = np.random.default_rng(0).standard_normal((len(rows), 2 * MOST_MODES))
    for _ in range(PASSES):
        directions, _ = np.linalg.qr(rows.T @ sample)
        sample, _ = np.linalg.qr(rows @ directions)
    sketched: Array = sample.T @ rows
    return sketched


def _mode_counts(sheets: Sequence[_Analysed], largest: int) -> list[int]:
    """How many modes each pattern keeps, at least one: the largest of all, as many as fit."""
    counts = [1] * len(sheets)
    left = largest - NAMES - sum(sheet.mode_bytes + sheet.other_bytes for sheet in sheets)
    wanted = [(-size, number) for number, sheet in enumerate(sheets) for size in sheet.sizes[1:]]
    for _, number in sorted(wanted):
        left -= sheets[number].mode_bytes
        if left < 0:
            break
        counts[number] += 1
    return counts


def _sheet(growth: Growth, number: int, nodes: Sequence[Node], gait: int, sheet: _Analysed, modes: int) -> Sheet:
    vectors = sheet.modes[:modes]
    coordinates, tangents = (
        rounded(numbers @ vectors.T, ROUNDED_ALONG[name])
        for name, numbers in (("coordinates", sheet.points), ("tangents", sheet.tangents))
    )
    return Sheet(
        gait=gait,
        pattern=growth.solver.patterns[number].text,
        space=growth.solver.methods[number].space,
        tasks=sheet.places,
        costs=np.array([node.cost for node in nodes]),
        slopes=np.array([node.slopes for node in nodes]),
        mean=(sheet.mean / sheet.weights).astype(np.float32),
        modes=rounded(vectors / sheet.weights, ROUNDED_ALONG["modes"]),
        coordinates=coordinates,
        tangents=tangents,
        tear=_tear(sheet.pairs, sheet.places, coordinates, tangents),
        infeasible=sheet.beyond,
    )


def _beyond(growth: Growth, number: int, nodes: Sequence[Node]) -> Array:
    """Of the places [m, a] where a pattern has no motion those that tell where it ends.

    A sheet's support weighs them all against its nodes. Searching for borders piles places up in front of them, which
    would move a border to the nodes' side. So a node is faced by the nearest place alone; places that are far from all
    nodes stay.
    """
    places = growth.infeasible_places(number)
    if not len(places):
        return places
    steps, at = growth.steps, np.array([node.place for node in nodes])
    away, nearest = cKDTree(places / steps).query(at / steps)
    kept = np.zeros(len(places), dtype=bool)
    kept[nearest[away < REACH]] = True
    kept |= cKDTree(at / steps).query(places / steps)[0] > FAR
    beyond: Array = places[kept]
    return beyond


def _tear(pairs: NDArray[np.intp], places: Array, coordinates: NDArray[Any], tangents: NDArray[Any]) -> float:
    """Several times the usual distance of what two neighbours predict half-way: what differs more is another motion."""
    if not len(pairs):
        return 0.0
    one, other = pairs.T
    half = (places[other] - places[one])[:, None] / 2
    apart = coordinates[one] + (half @ tangents[one])[:, 0] - coordinates[other] + (half @ tangents[other])[:, 0]
    return float(TEAR * np.median(np.linalg.norm(apart, axis=1)))


def _without_strays(pairs: NDArray[np.intp], points: Array, tangents: Array) -> tuple[Array, Array]:
    """The points with those replaced that have nothing in common with any neighbour, by the mean of the neighbours'.

    Where the rows of a motion depend on each other its multipliers have no bounds, and a point may run away along them.
    """
    if not len(pairs):
        return points, tangents
    distances = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    nearest = np.full(len(points), np.inf)
    for side in (0, 1):
        np.minimum.at(nearest, pairs[:, side], distances)
    stray = np.isfinite(nearest) & (nearest > STRAY * np.median(distances))
    points, tangents = points.copy(), tangents.copy()
    for row in np.flatnonzero(stray):
        beside = np.concatenate([pairs[pairs[:, 0] == row, 1], pairs[pairs[:, 1] == row, 0]])
        sound = beside[~stray[beside]]
        if len(sound):
            points[row], tangents[row] = points[sound].mean(axis=0), tangents[sound].mean(axis=0)
    return points, tangents


def _pairs(places: Array) -> NDArray[np.intp]:
    """Rows [p, 2] of neighbouring nodes, by their places [n, a] in steps."""
    found = cKDTree(places).query_pairs(BESIDE, output_type="ndarray")
    return np.array(found[np.lexsort(found.T)], dtype=np.intp).reshape(-1, 2)
