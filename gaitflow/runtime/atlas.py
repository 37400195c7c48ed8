"""atlas.safetensors: solved tasks of every gait, so dense that the start for a task between them can be read off.

A sheet belongs to one full pattern of a gait and lies over a grid of tasks, finer than the map's. A node of it holds
the cost and the primal-dual point on the central path, as coordinates along the sheet's own modes. Between nodes they
are blended. A gait may have several sheets, as which phases it repeats may depend on the task.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load, save

from gaitflow.core.errors import ArtifactError
from gaitflow.core.trajectory import Array
from gaitflow.runtime.layout import Layout
from gaitflow.solvers.point import GaitSpace

MAX_AXIS = 2000
MAX_MODES = 512
MAX_SHEETS = 4096
MAX_CELLS = 4_000_000  # sheets times tasks: what the tables to look nodes up in have memory for
LARGEST_LOG = 700.0  # of a cost, so that its exponential is a number
SUPPORT = 0.75  # share of the surrounding nodes that a cost has to rest on to be believed
_NUMBERS = ("places", "costs", "mean", "modes", "coordinates", "tear")
_BOUNDS = ("lower", "upper", "lower_rows", "upper_rows")
_NAMES = ("gait", "pattern", *_BOUNDS, *_NUMBERS)


@dataclass(frozen=True)
class Sheet:
    """One full pattern, "0110/1100", of the map's gait number `gait`: n nodes, k modes of ny numbers.

    space: the bounds that impose the pattern. places [n, 2]: indices on the atlas' axes (speed, cycle duration).
    costs [n]: the problem's, at the optimum. A node's point, in the space's code, is mean [ny] + coordinates [n, k] @
    modes [k, ny]. Nodes whose coordinates are further apart than `tear` are not blended.
    """

    gait: int
    pattern: str
    space: GaitSpace
    places: NDArray[np.int32]
    costs: Array
    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    coordinates: NDArray[np.float32]
    tear: float


@dataclass(frozen=True)
class Prediction:
    """The start of a sheet at a task: its cost, the problem's, and its point [ny] on the central path."""

    cost: float
    point: Array


@dataclass(frozen=True)
class Atlas:
    """Rising speeds [m/s] and cycle durations [s] of the nodes, and the sheets.

    `barrier` is the one of the central path that the nodes lie on, for a cost divided by its optimum.
    """

    speeds: tuple[float, ...]
    cycle_durations: tuple[float, ...]
    barrier: float
    sheets: tuple[Sheet, ...]

    @classmethod
    def empty(cls) -> Atlas:
        """An atlas that knows nothing."""
        return cls((0.0, 1.0), (0.0, 1.0), 1e-4, ())

    def of(self, gaits: Sequence[int]) -> Atlas:
        """The sheets of some of the gaits, which become numbers 0, 1, ... in the order of `gaits`."""
        number = {gait: new for new, gait in enumerate(gaits)}
        kept = (sheet for sheet in self.sheets if sheet.gait in number)
        return replace(self, sheets=tuple(replace(sheet, gait=number[sheet.gait]) for sheet in kept))

    def costs(self, speed: float, cycle_duration: float) -> tuple[Array, Array]:
        """The problem's cost of each sheet at a task, blended from the surrounding nodes, and how much it rests on.

        The second is the share of those nodes that exist, by their weights; where it is 0 the cost is NaN.
        """
        logs, known = self._tables
        i, j, weights = self._around(speed, cycle_duration)
        near = np.s_[:, i : i + 2, j : j + 2]
        share = (known[near] * weights).sum(axis=(1, 2))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.exp((logs[near] * weights).sum(axis=(1, 2)) / share), share

    def ranked(self, speed: float, cycle_duration: float) -> list[int]:
        """The sheets with a node around a task, one for each gait; of equal ones the first.

        First those whose cost rests on most of the nodes around, cheapest first, then the others: where a gait lacks
        nodes it costs more than it seems, or has no motion.
        """
        costs, share = self.costs(speed, cycle_duration)
        best: dict[int, int] = {}
        for sheet in np.lexsort((costs, share < SUPPORT)).tolist():
            if share[sheet] > 0:
                best.setdefault(self.sheets[sheet].gait, sheet)
        return list(best.values())

    def predict(self, sheet: int, speed: float, cycle_duration: float) -> Prediction | None:
        """The start of a sheet at a task; None where no surrounding node was solved."""
        chosen, index = self.sheets[sheet], self._index[sheet]
        i, j, weights = self._around(speed, cycle_duration)
        nodes, weight = index[i : i + 2, j : j + 2].ravel(), weights.ravel()
        weight = np.where(nodes >= 0, weight, 0.0)
        if not weight.any():
            return None
        near = chosen.coordinates[nodes].astype(np.float64)
        apart = np.linalg.norm(near - near[weight.argmax()], axis=1)
        weight = np.where(apart <= chosen.tear, weight, 0.0)
        weight /= weight.sum()
        point = chosen.mean + (weight @ near) @ chosen.modes
        return Prediction(float(np.exp(weight @ np.log(chosen.costs[nodes]))), point)

    def least_cost(self, sheet: int, speed: float, cycle_duration: float) -> float:
        """What a sheet may cost at a task, the problem's, where its cost rises ever faster, as before a cliff.

        Then the blend of the nodes around is too much, and what the slopes outside of their cell promise too little:
        this is the largest of the promises. Infinite without any, and where too few of the nodes around exist.
        """
        logs, known = (table[sheet] for table in self._tables)
        i, j, weights = self._around(speed, cycle_duration)
        promises = []
        for (a, out_a), (b, out_b) in product(((i, i - 1), (i + 1, i + 2)), ((j, j - 1), (j + 1, j + 2))):
            if min(out_a, out_b) < 0 or out_a == len(self.speeds) or out_b == len(self.cycle_durations):
                continue
            if known[a, b] and known[out_a, b] and known[a, out_b]:
                by_speed = (logs[a, b] - logs[out_a, b]) / (self.speeds[a] - self.speeds[out_a])
                by_duration = (logs[a, b] - logs[a, out_b]) / (self.cycle_durations[b] - self.cycle_durations[out_b])
                ahead = speed - self.speeds[a], cycle_duration - self.cycle_durations[b]
                promises.append(logs[a, b] + by_speed * ahead[0] + by_duration * ahead[1])
        if not promises or (known[i : i + 2, j : j + 2] * weights).sum() < SUPPORT:
            return float("inf")
        return float(np.exp(min(max(promises), LARGEST_LOG)))

    def nearest(self, sheet: int, speed: float, cycle_duration: float, count: int) -> list[Prediction]:
        """The `count` nodes of a sheet that are nearest to a task, by steps of the axes, nearest first."""
        chosen = self.sheets[sheet]
        tasks, steps = self._tasks[sheet]
        with np.errstate(over="ignore"):  # however far a task lies beyond
            away = (((tasks - (speed, cycle_duration)) / steps) ** 2).sum(axis=1)
        order = np.argsort(away, kind="stable")[:count]
        points = chosen.mean + chosen.coordinates[order].astype(np.float64) @ chosen.modes
        return [Prediction(float(cost), point) for cost, point in zip(chosen.costs[order], points, strict=True)]

    @cached_property
    def _tasks(self) -> list[tuple[Array, Array]]:
        axes = np.array(self.speeds), np.array(self.cycle_durations)
        steps = np.array([np.diff(axis).mean() for axis in axes])
        places = [sheet.places for sheet in self.sheets]
        return [(np.column_stack([axes[0][each[:, 0]], axes[1][each[:, 1]]]), steps) for each in places]

    @cached_property
    def _index(self) -> list[NDArray[np.intp]]:
        shape = (len(self.speeds), len(self.cycle_durations))
        tables = [np.full(shape, -1, dtype=np.intp) for _ in self.sheets]
        for table, sheet in zip(tables, self.sheets, strict=True):
            table[sheet.places[:, 0], sheet.places[:, 1]] = np.arange(len(sheet.places))
        return tables

    @cached_property
    def _tables(self) -> tuple[Array, Array]:
        shape = (len(self.sheets), len(self.speeds), len(self.cycle_durations))
        logs, known = np.zeros(shape), np.zeros(shape)
        for number, sheet in enumerate(self.sheets):
            logs[number, sheet.places[:, 0], sheet.places[:, 1]] = np.log(sheet.costs)
            known[number, sheet.places[:, 0], sheet.places[:, 1]] = 1.0
        return logs, known

    def _around(self, speed: float, cycle_duration: float) -> tuple[int, int, Array]:
        """The lower indices of a task's cell, and the bilinear weights [2, 2] of its corners; the nearest beyond."""
        i, s = _cell(self.speeds, speed)
        j, t = _cell(self.cycle_durations, cycle_duration)
        return i, j, np.array([[(1 - s) * (1 - t), (1 - s) * t], [s * (1 - t), s * t]])


def _cell(axis: Sequence[float], value: float) -> tuple[int, float]:
    index = min(max(bisect_right(axis, value) - 1, 0), len(axis) - 2)
    return index, min(max((value - axis[index]) / (axis[index + 1] - axis[index]), 0.0), 1.0)


def atlas_bytes(atlas: Atlas) -> bytes:
    """The file's content. Equal atlases give equal bytes."""
    tensors: dict[str, NDArray[Any]] = {
        "speeds": np.array(atlas.speeds),
        "cycle_durations": np.array(atlas.cycle_durations),
        "barrier": np.array([atlas.barrier]),
        "sheets": np.array([len(atlas.sheets)], dtype=np.int32),
    }
    for number, sheet in enumerate(atlas.sheets):
        own = {name: getattr(sheet, name) for name in _NUMBERS[:-1]}
        own |= {name: getattr(sheet.space, name) for name in _BOUNDS}
        own |= {
            "gait": np.array([sheet.gait], dtype=np.int32),
            "pattern": np.array([[int(digit) for digit in row] for row in sheet.pattern.split("/")], dtype=np.uint8),
            "tear": np.array([sheet.tear]),
        }
        tensors |= {f"{number}.{name}": np.ascontiguousarray(value) for name, value in own.items()}
    return save(tensors)


def parse_atlas(content: bytes, gaits: int, layout: Layout, where: str) -> Atlas:
    """The atlas in a file's bytes, checked for names, types, shapes and values. Raises ArtifactError."""
    try:
        tensors = load(content)
    except (SafetensorError, KeyError, ValueError) as error:  # KeyError: an element type numpy does not have
        raise ArtifactError(f"{where}: not a safetensors file ({str(error)[:200]}); copy the artifact again") from None
    file = _File(tensors, where)
    count = int(file.array("sheets", (1,), np.int32)[0])
    if not 0 <= count <= MAX_SHEETS:
        raise ArtifactError(f"{where}: sheets = {count}: must be 0 to {MAX_SHEETS}")
    expected = {"speeds", "cycle_durations", "barrier", "sheets"}
    expected |= {f"{number}.{name}" for number in range(count) for name in _NAMES}
    if odd := sorted(set(tensors) ^ expected):
        raise ArtifactError(f"{where}: {odd[0][:80]} is missing or too much: the atlas has {count} sheets")
    barrier = float(file.array("barrier", (1,), np.float64)[0])
    if not 0 < barrier < 1:
        raise ArtifactError(f"{where}: barrier = {barrier:g}: must lie between 0 and 1")
    axes = file.axis("speeds"), file.axis("cycle_durations")
    if count * len(axes[0]) * len(axes[1]) > MAX_CELLS:
        file.refuse(
            "the atlas", f"has {count} sheets over {len(axes[0])} by {len(axes[1])} tasks: more than {MAX_CELLS}"
        )
    sheets = tuple(_sheet(file, number, gaits, layout, (len(axes[0]), len(axes[1]))) for number in range(count))
    return Atlas(*axes, barrier, sheets)


def _sheet(file: _File, number: int, gaits: int, layout: Layout, tasks: tuple[int, int]) -> Sheet:
    name = f"sheet {number}"
    (gait,) = file.array(f"{number}.gait", (1,), np.int32).tolist()
    if not 0 <= gait < gaits:
        file.refuse(name, f"is of gait {gait}; the map has {gaits}")
    pattern = file.array(f"{number}.pattern", (len(layout.legs), layout.phases), np.uint8)
    if pattern.max() > 1:
        file.refuse(name, "has a pattern of more than 0 and 1")
    sizes = (layout.variables, layout.variables, layout.rows, layout.rows)
    bounds = [
        file.array(f"{number}.{each}", (size,), np.float64, finite=False)
        for each, size in zip(_BOUNDS, sizes, strict=True)
    ]
    if (bounds[0] > bounds[1]).any() or (bounds[2] > bounds[3]).any():
        file.refuse(name, "has a bound below that lies above the one above")
    if any(np.isposinf(each).any() for each in bounds[::2]) or any(np.isneginf(each).any() for each in bounds[1::2]):
        file.refuse(name, "has an infinite bound on the wrong side")
    space = GaitSpace(*bounds)
    if not (len(space.free) and space.rows and space.bounds):
        file.refuse(name, "leaves no variable, no row or no bound to solve for")
    nodes, modes = file.length(f"{number}.places"), file.length(f"{number}.modes")
    if nodes > tasks[0] * tasks[1] or modes > MAX_MODES:
        file.refuse(name, f"has {nodes} nodes and {modes} modes; at most {tasks[0] * tasks[1]} and {MAX_MODES} fit")
    places = file.array(f"{number}.places", (nodes, 2), np.int32)
    costs = file.array(f"{number}.costs", (nodes,), np.float64)
    tear = float(file.array(f"{number}.tear", (1,), np.float64)[0])
    if not ((places >= 0) & (places < tasks)).all() or len(np.unique(places, axis=0)) < nodes:
        file.refuse(name, f"has two nodes at a task, or one off the {tasks[0]} by {tasks[1]} tasks")
    if (costs <= 0).any() or tear < 0:
        file.refuse(name, "holds a cost that is not positive, or a negative tear")
    return Sheet(
        gait=gait,
        pattern="/".join("".join(map(str, row)) for row in pattern.tolist()),
        space=space,
        places=places,
        costs=costs,
        mean=file.array(f"{number}.mean", (space.size,), np.float32),
        modes=file.array(f"{number}.modes", (modes, space.size), np.float32),
        coordinates=file.array(f"{number}.coordinates", (nodes, modes), np.float32),
        tear=tear,
    )


@dataclass(frozen=True)
class _File:
    """Tensors that nobody has checked yet; every method raises ArtifactError."""

    tensors: Mapping[str, NDArray[Any]]
    where: str

    def refuse(self, name: str, fault: str) -> NoReturn:
        raise ArtifactError(f"{self.where}: {name} {fault}; copy the artifact again or publish a new version")

    def length(self, name: str) -> int:
        if name not in self.tensors or not self.tensors[name].ndim:
            self.refuse(name, "is missing or has no length")
        return len(self.tensors[name])

    def array(self, name: str, shape: tuple[int, ...], kind: type, finite: bool = True) -> NDArray[Any]:
        tensor = self.tensors.get(name)
        if tensor is None or tensor.dtype != kind or tensor.shape != shape:
            found = "missing" if tensor is None else f"{tensor.dtype} {tensor.shape}"
            self.refuse(name, f"is {found}; expected {np.dtype(kind)} {shape}")
        if np.isnan(tensor).any() or (finite and not np.isfinite(tensor).all()):
            self.refuse(name, "holds a value that is not finite")
        tensor.flags.writeable = False
        return tensor

    def axis(self, name: str) -> tuple[float, ...]:
        size = self.length(name)
        if not 2 <= size <= MAX_AXIS:
            self.refuse(name, f"has {size} values; expected 2 to {MAX_AXIS}")
        values = self.array(name, (size,), np.float64)
        if (np.diff(values) <= 0).any():
            self.refuse(name, "must rise")
        return tuple(values.tolist())
