"""An atlas from bytes that nobody has checked yet; `gaitflow.runtime.atlas_file` says what is in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.runtime.atlas_file import (
    BOUNDS,
    EXPONENTS,
    IMAGE_OF,
    INFEASIBLE,
    OF_IMAGE,
    OF_SHEET,
    ROUNDED_ALONG,
)
from gaitflow.runtime.condensed import Condenser
from gaitflow.runtime.fixed_point import single
from gaitflow.runtime.levels import LEVELS, read_bounds
from gaitflow.runtime.sheet_image import SheetImage, imaged, signs_of
from gaitflow.runtime.strict import LARGEST
from gaitflow.runtime.tensor_file import TensorFile
from gaitflow.solvers.point import GaitSpace

MAX_MODES = 512
MAX_SHEETS = 4096
MAX_NODES = 1_000_000  # of all sheets


def parse_atlas(content: bytes, axes: Sequence[str], gaits: int, layout: Layout, rows: int, where: str) -> Atlas:
    """The atlas in a file's bytes, checked for names, types, shapes and values.

    axes are the map's ranged ones, gaits how many it has, rows those of its problem, `where` what errors call the file.
    Raises ArtifactError.
    """
    file = TensorFile.parse(content, where)
    count = int(file.array("sheets", (1,), np.int32)[0])
    if not 0 <= count <= MAX_SHEETS:
        file.refuse("sheets", f"= {count}: must be 0 to {MAX_SHEETS}")
    images = {number for number in range(count) if f"{number}.{IMAGE_OF}" in file.tensors}
    others = sorted(set(range(count)) - images)
    optional = {f"{number}.{INFEASIBLE}" for number in others} & set(file.tensors)
    exponents = {f"{number}.{name}{EXPONENTS}" for number in others for name in ROUNDED_ALONG}
    required = {f"{number}.{name}" for number in range(count) for name in (OF_IMAGE if number in images else OF_SHEET)}
    file.expect(
        {"axes", "steps", "barrier", "sheets"} | required | optional | (exponents | {LEVELS}) & set(file.tensors)
    )
    found = file.names("axes")
    if found != tuple(axes):
        file.refuse("axes", f"are {', '.join(found)}; the map's are {', '.join(axes)}")
    barrier = float(file.array("barrier", (1,), np.float64)[0])
    if not 0 < barrier < 1:
        file.refuse("barrier", f"= {barrier:g}: must lie between 0 and 1")
    steps = file.array("steps", (len(axes),), np.float64)
    if (steps < 1e-9).any():
        file.refuse("steps", "must be positive")
    for name, places in (("nodes", [f"{number}.tasks" for number in others]), ("infeasible places", optional)):
        if (found_places := sum(map(file.length, places))) > MAX_NODES:
            file.refuse("the atlas", f"has {found_places} {name}: more than {MAX_NODES}")
    sheets = {number: _sheet(file, number, found, barrier, gaits, layout, rows) for number in others}
    sheets |= {number: _image(file, number, sheets, found, barrier, gaits, layout, rows) for number in sorted(images)}
    return Atlas(found, steps, barrier, tuple(sheets[number] for number in range(count)))


def parse_space(file: TensorFile, prefix: str, layout: Layout, rows: int) -> GaitSpace:
    """The bounds of a sheet, "<prefix>.lower" and so on. Raises ArtifactError."""
    sizes = (layout.nw, layout.nw, rows, rows)
    bounds = [read_bounds(file, f"{prefix}.{each}", (size,)) for each, size in zip(BOUNDS, sizes, strict=True)]
    if (bounds[0] > bounds[1]).any() or (bounds[2] > bounds[3]).any():
        file.refuse(f"sheet {prefix}", "has a bound below that lies above the one above")
    if any(np.isposinf(each).any() for each in bounds[::2]) or any(np.isneginf(each).any() for each in bounds[1::2]):
        file.refuse(f"sheet {prefix}", "has an infinite bound on the wrong side")
    space = GaitSpace(*bounds)
    if not (len(space.free) and space.rows and space.bounds):
        file.refuse(f"sheet {prefix}", "leaves no variable, no row or no bound to solve for")
    return space


def parse_pattern(file: TensorFile, prefix: str, layout: Layout) -> str:
    """The pattern of a sheet as text. Raises ArtifactError."""
    pattern = file.array(f"{prefix}.pattern", (layout.legs, layout.phases), np.uint8)
    if pattern.max() > 1:
        file.refuse(f"sheet {prefix}", "has a pattern of more than 0 and 1")
    return "/".join("".join(map(str, row)) for row in pattern.tolist())


def parse_gait(file: TensorFile, prefix: str, gaits: int) -> int:
    """The number of a sheet's gait. Raises ArtifactError."""
    gait = int(file.array(f"{prefix}.gait", (1,), np.int32)[0])
    if not 0 <= gait < gaits:
        file.refuse(f"sheet {prefix}", f"is of gait {gait}; the map has {gaits}")
    return gait


def _sheet(
    file: TensorFile, number: int, axes: tuple[str, ...], barrier: float, gaits: int, layout: Layout, rows: int
) -> Sheet:
    own, name = str(number), f"sheet {number}"
    gait, pattern = parse_gait(file, own, gaits), parse_pattern(file, own, layout)
    space = parse_space(file, own, layout, rows)
    nodes, modes, a = file.length(f"{own}.tasks"), file.length(f"{own}.modes"), len(axes)
    if not nodes or not 1 <= modes <= MAX_MODES:
        file.refuse(name, f"has {nodes} nodes and {modes} modes; at least 1 of each, at most {MAX_MODES} modes")
    tasks = _tasks(file, f"{own}.tasks", axes, name)
    without = f"{own}.{INFEASIBLE}"
    costs = file.array(f"{own}.costs", (nodes,), np.float64)
    tear = float(file.array(f"{own}.tear", (1,), np.float64)[0])
    if (costs <= 0).any() or tear < 0:
        file.refuse(name, "holds a cost that is not positive, or a negative tear")
    size = file.length(f"{own}.mean")
    if size not in (space.size, Condenser(space, barrier).size):
        file.refuse(name, f"has points of {size} numbers; its pattern takes {space.size}, or half of them")
    return Sheet(
        gait=gait,
        pattern=pattern,
        space=space,
        tasks=tasks,
        costs=costs,
        slopes=file.array(f"{own}.slopes", (nodes, a), np.float64),
        mean=file.array(f"{own}.mean", (size,), np.float32),
        modes=_single(file, own, "modes", (modes, size)),
        coordinates=_single(file, own, "coordinates", (nodes, modes)),
        tangents=_single(file, own, "tangents", (nodes, a, modes)),
        tear=tear,
        infeasible=_tasks(file, without, axes, name) if without in file.tensors else np.zeros((0, a)),
    )


def _image(
    file: TensorFile,
    number: int,
    others: Mapping[int, Sheet],
    axes: tuple[str, ...],
    barrier: float,
    gaits: int,
    layout: Layout,
    rows: int,
) -> Sheet:
    own, name = str(number), f"sheet {number}"
    gait, pattern = parse_gait(file, own, gaits), parse_pattern(file, own, layout)
    space, of = parse_space(file, own, layout, rows), int(file.array(f"{own}.{IMAGE_OF}", (1,), np.int32)[0])
    if of not in others:
        file.refuse(name, f"is the image of sheet {of}, which is not there or an image itself")
    size = Condenser(space, barrier).size
    places = file.array(f"{own}.image_places", (size,), np.int32)
    signs = file.array(f"{own}.image_signs", (size,), np.int8)
    if len(others[of].mean) != size or (np.sort(places) != np.arange(size)).any() or (np.abs(signs) != 1).any():
        file.refuse(name, f"is no image of sheet {of}: its numbers do not follow from the other's, each from one")
    image = SheetImage(others[of].pattern, places.astype(np.intp), signs)
    return imaged(others[of], image, gait, pattern, space, signs_of(axes))


def _single(file: TensorFile, own: str, name: str, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Numbers that are in fixed point, or as they are in older maps."""
    tensor, exponents = f"{own}.{name}", f"{own}.{name}{EXPONENTS}"
    if exponents not in file.tensors:
        return file.array(tensor, shape, np.float32)
    along = ROUNDED_ALONG[name]
    powers = file.array(exponents, (*shape[:along], 1, *shape[along + 1 :]), np.int16)
    numbers = single(file.array(tensor, shape, np.int16), powers)
    if not (np.abs(numbers) <= LARGEST).all():
        file.refuse(exponents, f"leads beyond {LARGEST:g}")
    numbers.flags.writeable = False
    return numbers


def _tasks(file: TensorFile, tensor: str, axes: tuple[str, ...], name: str) -> Array:
    """At least one place of a sheet [n, a], each a physical task."""
    tasks = file.array(tensor, (file.length(tensor), len(axes)), np.float64)
    if not len(tasks):
        file.refuse(tensor, "is empty")
    ends = ((axis, x) for axis, column in zip(axes, tasks.T, strict=True) for x in (min(column), max(column)))
    if not all(AXES[axis].admits(x) for axis, x in ends):
        file.refuse(name, "has a node or an infeasible place that is no physical task")
    return tasks
