"""atlas.safetensors of format 2: nodes on a grid of speeds and cycle durations, without tangents.

They become today's nodes. Their tangents are differences of neighbours on the grid, where these belong to the same
motion, and 0 elsewhere.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.layout import Layout
from gaitflow.core.task_space import MAIN_AXES
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.runtime.atlas_file import BOUNDS
from gaitflow.runtime.atlas_reader import MAX_MODES, MAX_NODES, MAX_SHEETS, parse_gait, parse_pattern, parse_space
from gaitflow.runtime.tensor_file import TensorFile

MAX_AXIS = 2000
_GRID = ("speeds", "cycle_durations")
_NAMES = ("gait", "pattern", *BOUNDS, "places", "costs", "mean", "modes", "coordinates", "tear")


def parse_gridded_atlas(content: bytes, gaits: int, layout: Layout, rows: int, where: str) -> Atlas:
    """The atlas in a file's bytes, checked as `atlas_reader.parse_atlas` does. Raises ArtifactError."""
    file = TensorFile.parse(content, where)
    count = int(file.array("sheets", (1,), np.int32)[0])
    if not 0 <= count <= MAX_SHEETS:
        file.refuse("sheets", f"= {count}: must be 0 to {MAX_SHEETS}")
    file.expect({*_GRID, "barrier", "sheets"} | {f"{n}.{name}" for n in range(count) for name in _NAMES})
    barrier = float(file.array("barrier", (1,), np.float64)[0])
    if not 0 < barrier < 1:
        file.refuse("barrier", f"= {barrier:g}: must lie between 0 and 1")
    if sum(file.length(f"{number}.places") for number in range(count)) > MAX_NODES:
        file.refuse("the atlas", f"has more than {MAX_NODES} nodes")
    grid = tuple(_axis(file, name) for name in _GRID)
    sheets = tuple(_sheet(file, number, gaits, layout, rows, grid) for number in range(count))
    return Atlas(MAIN_AXES, np.array([np.diff(values).mean() for values in grid]), barrier, sheets)


def _axis(file: TensorFile, name: str) -> Array:
    size = file.length(name)
    if not 2 <= size <= MAX_AXIS:
        file.refuse(name, f"has {size} values; expected 2 to {MAX_AXIS}")
    values = file.array(name, (size,), np.float64)
    if (np.diff(values) <= 0).any():
        file.refuse(name, "must rise")
    return values


def _sheet(file: TensorFile, number: int, gaits: int, layout: Layout, rows: int, grid: tuple[Array, ...]) -> Sheet:
    own, name = str(number), f"sheet {number}"
    space, shape = parse_space(file, own, layout, rows), (len(grid[0]), len(grid[1]))
    nodes, modes = file.length(f"{own}.places"), file.length(f"{own}.modes")
    if not nodes or not 1 <= modes <= MAX_MODES:
        file.refuse(name, f"has {nodes} nodes and {modes} modes; at least 1 of each, at most {MAX_MODES} modes")
    places = file.array(f"{own}.places", (nodes, 2), np.int32)
    costs = file.array(f"{own}.costs", (nodes,), np.float64)
    tear = float(file.array(f"{own}.tear", (1,), np.float64)[0])
    if not ((places >= 0) & (places < shape)).all() or len(np.unique(places, axis=0)) < nodes:
        file.refuse(name, f"has two nodes at a task, or one off the {shape[0]} by {shape[1]} tasks")
    if (costs <= 0).any() or tear < 0:
        file.refuse(name, "holds a cost that is not positive, or a negative tear")
    tasks = np.column_stack([values[index] for values, index in zip(grid, places.T, strict=True)])
    coordinates = file.array(f"{own}.coordinates", (nodes, modes), np.float32)
    slopes = np.zeros((nodes, 2))
    tangents = np.zeros((nodes, 2, modes), dtype=np.float32)
    for axis in (0, 1):
        left, right = _neighbours(places, axis, coordinates, tear)
        width = tasks[right, axis] - tasks[left, axis]
        known = width > 0
        slopes[known, axis] = (np.log(costs[right]) - np.log(costs[left]))[known] / width[known]
        tangents[known, axis] = (coordinates[right] - coordinates[left])[known] / width[known, None]
    return Sheet(
        gait=parse_gait(file, own, gaits),
        pattern=parse_pattern(file, own, layout),
        space=space,
        tasks=tasks,
        costs=costs,
        slopes=slopes,
        mean=file.array(f"{own}.mean", (space.size,), np.float32),
        modes=file.array(f"{own}.modes", (modes, space.size), np.float32),
        coordinates=coordinates,
        tangents=tangents,
        tear=tear,
        infeasible=np.zeros((0, 2)),
    )


def _neighbours(
    places: NDArray[np.int32], axis: int, coordinates: NDArray[np.float32], tear: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """For every node the next ones below and above it along an axis, itself where there is none of the same motion."""
    keys = places[:, 0].astype(np.int64) * (MAX_AXIS + 2) + places[:, 1]  # no two nodes, and none off the grid, alike
    order = np.argsort(keys)
    step = MAX_AXIS + 2 if axis == 0 else 1
    ends = []
    for wanted in (keys - step, keys + step):
        found = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
        beside = keys[found] == wanted
        same = np.linalg.norm(coordinates[found].astype(np.float64) - coordinates, axis=1) <= tear
        ends.append(np.where(beside & same, found, np.arange(len(keys))))
    return ends[0], ends[1]
