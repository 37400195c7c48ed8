"""atlas.safetensors: the atlas' bytes, and an atlas from bytes that nobody has checked yet.

Tensors: `axes` (names in ASCII, joined by commas, uint8), `steps` [a] and `barrier` [1] (float64), `sheets` [1]
(int32), `levels` (float64), all values that bounds have, and for every sheet "<number>.<name>": gait [1] (int32),
pattern [legs, phases] (uint8), lower, upper [nw], lower_rows, upper_rows [ng] (uint8: which level), and the fields of
`Sheet` by their names. Of these mean is float32, most others float64. modes, coordinates and tangents are int16 in
fixed point (`gaitflow.runtime.fixed_point`) with exponents, int16 as well, in "<number>.<name>_exponents" [1, c],
[1, k] and [1, a, k]. A sheet without infeasible places has no tensor of them.

A sheet that is the mirror image of another one has its gait, pattern and bounds, and instead of numbers `image_of` [1]
(int32), the number of the other, `image_places` [c] (int32) and `image_signs` [c] (int8), see `SheetImage`.

In older maps bounds are float64, and fixed point is float32 without exponents. Bounds of more than 256 values, and
numbers that fixed point would change, are written so today.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import save

from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.runtime.atlas import Atlas, Sheet
from gaitflow.runtime.condensed import Condenser
from gaitflow.runtime.fixed_point import fixed_point, single
from gaitflow.runtime.sheet_image import SheetImage, imaged, signs_of
from gaitflow.runtime.strict import LARGEST
from gaitflow.runtime.tensor_file import TensorFile
from gaitflow.solvers.point import GaitSpace

MAX_MODES = 512
MAX_SHEETS = 4096
MAX_NODES = 1_000_000  # of all sheets
_NUMBERS = ("tasks", "costs", "slopes", "mean", "modes", "coordinates", "tangents")
ROUNDED_ALONG = {"modes": 0, "coordinates": 0, "tangents": 0}  # the axis whose numbers share an exponent
EXPONENTS = "_exponents"
LEVELS, MOST_LEVELS = "levels", 256
BOUNDS = ("lower", "upper", "lower_rows", "upper_rows")
INFEASIBLE = "infeasible"
IMAGE_OF = "image_of"
_NAMES = ("gait", "pattern", *BOUNDS, *_NUMBERS, "tear")
_IMAGE = ("gait", "pattern", *BOUNDS, IMAGE_OF, "image_places", "image_signs")


def atlas_bytes(atlas: Atlas) -> bytes:
    """The file's content. Equal atlases give equal bytes."""
    tensors: dict[str, NDArray[Any]] = {
        "axes": np.frombuffer(",".join(atlas.axes).encode("ascii"), dtype=np.uint8),
        "steps": np.array(atlas.steps, dtype=np.float64),
        "barrier": np.array([atlas.barrier]),
        "sheets": np.array([len(atlas.sheets)], dtype=np.int32),
    }
    bounds = [getattr(sheet.space, name) for sheet in atlas.sheets for name in BOUNDS]
    levels = np.unique(np.concatenate(bounds)) if bounds else np.zeros(0)
    tensors |= {LEVELS: levels} if 0 < len(levels) <= MOST_LEVELS else {}
    written = {sheet.pattern: number for number, sheet in enumerate(atlas.sheets) if sheet.image is None}
    for number, sheet in enumerate(atlas.sheets):
        is_image = sheet.image is not None and sheet.image.of in written
        own = _image_tensors(sheet.image, written) if is_image else _number_tensors(sheet)
        own |= {name: _levelled(getattr(sheet.space, name), tensors.get(LEVELS)) for name in BOUNDS}
        own |= {
            "gait": np.array([sheet.gait], dtype=np.int32),
            "pattern": np.array([[int(digit) for digit in row] for row in sheet.pattern.split("/")], dtype=np.uint8),
        }
        tensors |= {f"{number}.{name}": np.ascontiguousarray(value) for name, value in own.items()}
    return save(tensors)


def _number_tensors(sheet: Sheet) -> dict[str, NDArray[Any]]:
    own = {name: getattr(sheet, name) for name in _NUMBERS} | {"tear": np.array([sheet.tear])}
    own |= _in_fixed_point({name: own[name] for name in ROUNDED_ALONG})
    return own | ({INFEASIBLE: sheet.infeasible} if len(sheet.infeasible) else {})


def _image_tensors(image: SheetImage | None, written: Mapping[str, int]) -> dict[str, NDArray[Any]]:
    assert image is not None
    return {
        IMAGE_OF: np.array([written[image.of]], dtype=np.int32),
        "image_places": image.places.astype(np.int32),
        "image_signs": image.signs,
    }


def _levelled(bounds: Array, levels: Array | None) -> NDArray[Any]:
    return bounds if levels is None else np.searchsorted(levels, bounds).astype(np.uint8)


def _in_fixed_point(arrays: Mapping[str, NDArray[np.float32]]) -> dict[str, NDArray[Any]]:
    """The arrays with their exponents; as they are where that would change any of them, as of older maps."""
    tensors: dict[str, NDArray[Any]] = {}
    for name, numbers in arrays.items():
        whole, exponents = fixed_point(numbers, ROUNDED_ALONG[name])
        if not np.array_equal(single(whole, exponents), numbers):
            return dict(arrays)
        tensors |= {name: whole, name + EXPONENTS: exponents}
    return tensors


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
    required = {f"{number}.{name}" for number in range(count) for name in (_IMAGE if number in images else _NAMES)}
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
    bounds = [_bounds(file, f"{prefix}.{each}", size) for each, size in zip(BOUNDS, sizes, strict=True)]
    if (bounds[0] > bounds[1]).any() or (bounds[2] > bounds[3]).any():
        file.refuse(f"sheet {prefix}", "has a bound below that lies above the one above")
    if any(np.isposinf(each).any() for each in bounds[::2]) or any(np.isneginf(each).any() for each in bounds[1::2]):
        file.refuse(f"sheet {prefix}", "has an infinite bound on the wrong side")
    space = GaitSpace(*bounds)
    if not (len(space.free) and space.rows and space.bounds):
        file.refuse(f"sheet {prefix}", "leaves no variable, no row or no bound to solve for")
    return space


def _bounds(file: TensorFile, name: str, size: int) -> Array:
    """Bounds that are written out, or by which of the levels each is. Raises ArtifactError."""
    if LEVELS not in file.tensors:
        return file.array(name, (size,), np.float64, finite=False)
    levels = file.array(LEVELS, (file.length(LEVELS),), np.float64, finite=False)
    if len(levels) > MOST_LEVELS or (levels[1:] <= levels[:-1]).any():
        file.refuse(LEVELS, f"are more than {MOST_LEVELS}, or not in ascending order")
    which = file.array(name, (size,), np.uint8)
    if which.max(initial=0) >= len(levels):
        file.refuse(name, f"has level {which.max()}; there are {len(levels)}")
    bounds: Array = levels[which]
    bounds.flags.writeable = False
    return bounds


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
