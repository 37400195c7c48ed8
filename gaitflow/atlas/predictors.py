"""From grown nodes to the atlas that is published: which predictor, and how many modes, need the fewest iterations.

Every candidate predicts coordinates along the modes of a gait's sheet, and is judged where it matters: by the Newton
iterations from its prediction at tasks amid the nodes, none of which it has seen. The winner is tabulated at the nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from gaitflow.atlas.grow import BARRIER, COMPETITIVE, Grown, Place
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, Sheet

NODES = "nodes"  # blend of the nodes around a task
MODES = (16, 32, 48)
JUDGED = 24  # tasks a gait
LIMIT = 12  # iterations; a run that needs more counts with these
AS_GOOD = 1.02  # fewer modes are taken when they need at most this times the iterations
NEVER = 1e30
STRAY = 30.0  # times the usual distance of neighbours
TEAR = 4.0  # times the usual distance of neighbours
DEGREE = 3

Predictor = Callable[[Array], Array]  # tasks [m, 2] in steps of the nodes' axes -> coordinates [m, k]


@dataclass(frozen=True)
class Judgement:
    """A row of the table: how a predictor with so many modes did on `tasks` tasks that are no nodes.

    Without any task, of a grid of one task for instance, all do alike.
    """

    predictor: str
    modes: int
    tasks: int
    iterations_mean: float
    converged: int


def build_atlas(grown: Grown, gaits: Sequence[int]) -> tuple[Atlas, tuple[Judgement, ...]]:
    """The atlas of the predictor with the fewest iterations, and how all of them did.

    `gaits` are the numbers of the gaits that the grown patterns realise; patterns without a node have no sheet.
    """
    numbers = [number for number, nodes in enumerate(grown.nodes) if nodes]
    full = [_sheet(grown, number, gaits[number], max(MODES)) for number in numbers]
    tasks = [_judged(grown, number) for number in numbers]
    grown = replace(
        grown,
        patterns=tuple(grown.patterns[number] for number in numbers),
        methods=tuple(grown.methods[number] for number in numbers),
        nodes=tuple(grown.nodes[number] for number in numbers),
    )
    candidates = {(NODES, modes): [_thinner(sheet, modes) for sheet in full] for modes in MODES}
    for name in FAMILIES:
        candidates[name, max(MODES)] = [_tabulated(grown, number, sheet, name) for number, sheet in enumerate(full)]
    rows = tuple(_judge(grown, sheets, tasks, *key) for key, sheets in candidates.items())
    best = min(row.iterations_mean for row in rows)
    winner = min(
        (row for row in rows if row.iterations_mean <= AS_GOOD * best), key=lambda row: (row.modes, row.iterations_mean)
    )
    return _atlas(grown, candidates[winner.predictor, winner.modes]), rows


def table(rows: tuple[Judgement, ...]) -> list[dict[str, object]]:
    """The judgements as plain data."""
    return [asdict(row) for row in rows]


def _atlas(grown: Grown, sheets: list[Sheet]) -> Atlas:
    return Atlas(grown.speeds, grown.cycle_durations, BARRIER, tuple(sheets))


def _sheet(grown: Grown, number: int, gait: int, modes: int) -> Sheet:
    space, nodes = grown.methods[number].space, grown.nodes[number]
    places = sorted(nodes)
    numbers = _without_strays(places, np.array([space.encode(nodes[place].point) for place in places]))
    mean = numbers.mean(axis=0)
    left, sizes, right = np.linalg.svd(numbers - mean, full_matrices=False)
    kept = min(modes, len(sizes))
    coordinates = left[:, :kept] * sizes[:kept]
    return Sheet(
        gait=gait,
        pattern=grown.patterns[number].text,
        space=space,
        places=np.array(places, dtype=np.int32),
        costs=np.array([nodes[place].cost for place in places]),
        mean=mean.astype(np.float32),
        modes=right[:kept].astype(np.float32),
        coordinates=coordinates.astype(np.float32),
        tear=_tear(places, coordinates),
    )


def _tear(places: list[Place], coordinates: Array) -> float:
    """Several times the usual distance of neighbouring nodes: what is further apart is another motion."""
    distances = _distances(_pairs(places), coordinates)
    return float(TEAR * np.median(distances)) if len(distances) else 0.0


def _without_strays(places: list[Place], numbers: Array) -> Array:
    """The points with those replaced that have nothing in common with any neighbour, by the mean of the neighbours'.

    Where the rows of a motion depend on each other its multipliers have no bounds, and a point may run away along them.
    """
    pairs = _pairs(places)
    distances = _distances(pairs, numbers)
    if not len(pairs):
        return numbers
    nearest = np.full(len(places), np.inf)
    for side in (0, 1):
        np.minimum.at(nearest, pairs[:, side], distances)
    stray = np.isfinite(nearest) & (nearest > STRAY * np.median(distances))
    kept = numbers.copy()
    for row in np.flatnonzero(stray):
        beside = np.concatenate([pairs[pairs[:, 0] == row, 1], pairs[pairs[:, 1] == row, 0]])
        sound = beside[~stray[beside]]
        if len(sound):
            kept[row] = numbers[sound].mean(axis=0)
    return kept


def _pairs(places: list[Place]) -> NDArray[np.intp]:
    """Rows [p, 2] of neighbouring nodes."""
    index = {place: row for row, place in enumerate(places)}
    found = [(row, index[near]) for (i, j), row in index.items() for near in ((i + 1, j), (i, j + 1)) if near in index]
    return np.array(found, dtype=np.intp).reshape(-1, 2)


def _distances(pairs: NDArray[np.intp], numbers: Array) -> Array:
    return np.linalg.norm(numbers[pairs[:, 0]] - numbers[pairs[:, 1]], axis=1)


def _thinner(sheet: Sheet, modes: int) -> Sheet:
    return replace(sheet, modes=sheet.modes[:modes], coordinates=np.ascontiguousarray(sheet.coordinates[:, :modes]))


def _tabulated(grown: Grown, number: int, sheet: Sheet, family: str) -> Sheet:
    """The sheet with a family's predictions in the place of the nodes' own coordinates."""
    nodes, best = grown.nodes[number], _cheapest(grown)
    own = np.array([nodes[place].cost <= best[place] for place in map(tuple, sheet.places.tolist())])
    tasks, coordinates = sheet.places.astype(float), sheet.coordinates.astype(float)
    predict = FAMILIES[family](tasks, coordinates, own if own.any() else ~own)
    return replace(sheet, coordinates=predict(tasks).astype(np.float32), tear=NEVER)


def _mean(tasks: Array, coordinates: Array, own: Array) -> Predictor:
    """The paper's: the mean over the gait's region, the nodes where it is the cheapest."""
    mean = coordinates[own].mean(axis=0)
    return lambda asked: np.tile(mean, (len(asked), 1))


def _cubic(tasks: Array, coordinates: Array, own: Array) -> Predictor:
    low, width = tasks.min(axis=0), np.ptp(tasks, axis=0) + 1.0

    def powers(asked: Array) -> Array:
        v, t = ((asked - low) / width).T
        return np.column_stack([v**i * t**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)])

    weights = np.linalg.lstsq(powers(tasks), coordinates, rcond=None)[0]
    return lambda asked: powers(asked) @ weights


def _kernel(tasks: Array, coordinates: Array, own: Array) -> Predictor:
    """Thin-plate splines, smoothed a little, so that they are more than the nodes they are tabulated at."""
    if len(tasks) < 4 or np.linalg.matrix_rank(tasks - tasks[0]) < 2:
        return lambda asked: coordinates
    return RBFInterpolator(tasks, coordinates, neighbors=min(50, len(tasks)), smoothing=1.0)


FAMILIES: Mapping[str, Callable[[Array, Array, Array], Predictor]] = {
    "mean": _mean,
    "cubic": _cubic,
    "kernel": _kernel,
}


def _judged(grown: Grown, number: int) -> list[tuple[float, float]]:
    """Tasks amid four nodes of a pattern that is competitive there, spread evenly."""
    best, nodes = _cheapest(grown), grown.nodes[number]
    cells = [
        (i, j)
        for (i, j), node in sorted(nodes.items())
        if node.cost <= COMPETITIVE * best[i, j] and {(i + 1, j), (i, j + 1), (i + 1, j + 1)} <= set(nodes)
    ]
    few = cells[:: max(1, len(cells) // JUDGED)][:JUDGED]
    v, t = grown.speeds, grown.cycle_durations
    return [((v[i] + v[i + 1]) / 2, (t[j] + t[j + 1]) / 2) for i, j in few]


def _cheapest(grown: Grown) -> dict[Place, float]:
    best: dict[Place, float] = {}
    for nodes in grown.nodes:
        for place, node in nodes.items():
            best[place] = min(node.cost, best.get(place, np.inf))
    return best


def _judge(
    grown: Grown, sheets: list[Sheet], tasks: list[list[tuple[float, float]]], predictor: str, modes: int
) -> Judgement:
    atlas, iterations = _atlas(grown, sheets), []
    for number, method in enumerate(grown.methods):
        for speed, duration in tasks[number]:
            predicted = atlas.predict(number, speed, duration)
            assert predicted is not None, "judged tasks lie amid nodes"
            start = method.space.decode(predicted.point)
            outcome = method.follow(np.array([speed, duration]), start, predicted.cost, BARRIER, LIMIT)
            iterations.append((outcome.iterations if outcome.converged else LIMIT, outcome.converged))
    counts = np.array(iterations, dtype=float).reshape(-1, 2)
    mean = float(counts[:, 0].mean()) if len(counts) else float(LIMIT)
    return Judgement(predictor, modes, len(counts), mean, int(counts[:, 1].sum()))
