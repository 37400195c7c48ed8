"""Readers of a manifest's fields, shared by all formats; every one raises ArtifactError that names the field."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.errors import ArtifactError
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.legacy import modern_name, modern_scenario
from gaitflow.core.task import AXES
from gaitflow.motion.frames import are_frames
from gaitflow.runtime.files import LIMITS, FileEntry
from gaitflow.runtime.json_schema import fault_of
from gaitflow.runtime.manifest import TIME_FORMAT, Gait
from gaitflow.runtime.strict import LARGEST, Fields, is_number, shown
from gaitflow.runtime.versions import Version
from gaitflow.solvers.options import Options, checked_options

MAX_GAITS = 4096
MAX_AXIS = 10_000
MAX_TASKS = 10_000_000
MAX_ITERATIONS = 1000  # of IPOPT: maps have 110, and with many more a plan that fails would take minutes
SIZED = ("robot", "objective", "swing_clearance")  # parts of a scenario whose numbers planning multiplies


def version(fields: Fields) -> Version:
    """The map's version."""
    try:
        return Version.parse(fields.text("version"))
    except ValueError as error:
        fields.refuse("version", str(error))


def created(fields: Fields) -> datetime:
    """When it was made, UTC."""
    try:
        return datetime.strptime(fields.text("created") + "+0000", TIME_FORMAT + "%z")
    except ValueError:
        fields.refuse("created", "UTC such as 2026-01-31T12:00:00Z")


def scenario(fields: Fields) -> Mapping[str, Any]:
    """The scenario in today's form, each field of which is checked as in a YAML file."""
    try:
        data = modern_scenario(fields.mapping("scenario"))
    except ValueError as error:
        fields.refuse("scenario", str(error))
    if fault := fault_of(data, _schema()):
        fields.refuse_inner("scenario", fault)
    if fault := next((fault for part in SIZED for fault in _too_large(data.get(part), part)), None):
        fields.refuse_inner("scenario", fault)
    robot, axes = data["robot"], data["tasks"]["axes"]
    ranged = [values for values in axes.values() if isinstance(values, dict)]
    ends = [(axis, value) for axis, values in axes.items() for value in _ends(values)]
    sound = {
        "robot.frames": robot.get("frames") is None or are_frames(robot["frames"], robot["legs"]),
        "tasks.axes": bool(ranged)
        and "cycle_duration" in axes
        and all(AXES[axis].admits(value) for axis, value in ends),
    }
    for name, holds in sound.items():
        if not holds:
            fields.refuse("scenario", f"a scenario with a sound {name}")
    return data


def feasible(fields: Fields, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """`feasible`, lists in lists of this shape that hold booleans."""
    if math.prod(shape) > MAX_TASKS:
        fields.refuse("feasible", f"at most {MAX_TASKS} tasks")
    cells: list[Any] = [fields.items("feasible", shape[0])]
    for size in shape:
        if not all(isinstance(each, list) and len(each) == size for each in cells):
            fields.refuse("feasible", f"booleans in lists of the shape {shape}, one level an axis")
        cells = [cell for each in cells for cell in each]
    if not all(type(cell) is bool for cell in cells):
        fields.refuse("feasible", f"booleans in lists of the shape {shape}, one level an axis")
    return np.array(cells, dtype=bool).reshape(shape)


def gaits(fields: Fields, layout: Layout) -> tuple[Gait, ...]:
    """The gaits, of different names and keys, whose patterns fit the layout."""
    found = tuple(
        _gait(Fields(item, f"gaits[{index}]", ("name", "key", "pattern")), layout)
        for index, item in enumerate(fields.items("gaits", MAX_GAITS))
    )
    if len({gait.name for gait in found}) < len(found) or len({gait.key for gait in found}) < len(found):
        fields.refuse("gaits", "gaits of different names and keys")
    return found


def solver_options(fields: Fields) -> Options:
    """The options in `solver` that IPOPT may be given."""
    try:
        options = checked_options(fields.inner("solver", ("options",)).mapping("options"))
    except ArtifactError as error:
        fields.refuse_inner("solver", shown(str(error).removeprefix("solver."), 800))
    if (most := options.get("max_iter", 0)) > MAX_ITERATIONS:  # type: ignore[operator]  # checked to be an integer
        fields.refuse_inner("solver", f"options.max_iter = {most}: must be an integer from 0 to {MAX_ITERATIONS}")
    return options


def file_entries(fields: Fields, names: Sequence[str]) -> Mapping[str, FileEntry]:
    """Digest and size of each of the files `names`."""
    entries = {}
    for name in names:
        entry = fields.inner(name, ("sha256", "bytes"))
        entries[name] = FileEntry(entry.digest("sha256"), entry.integer("bytes", 0, LIMITS[name]))
    return entries


def _gait(fields: Fields, layout: Layout) -> Gait:
    for name in ("key", "pattern"):
        try:
            pattern = Pattern.from_text(fields.text(name))
        except ValueError as error:
            fields.refuse(name, str(error))
        fits = pattern.phases == layout.phases if name == "pattern" else pattern.phases <= layout.phases
        if pattern.legs != layout.legs or not fits:
            fields.refuse(
                name, f"a pattern of {layout.legs} legs and {layout.phases} phases (a key may have fewer phases)"
            )
    return Gait(modern_name(fields.text("name")), fields.text("key"), fields.text("pattern"))


def _too_large(data: Any, name: str) -> Iterator[str]:
    """What a number in plain data is, and where, if it is beyond LARGEST."""
    parts: list[tuple[str, Any]] = []
    if isinstance(data, Mapping):
        parts = [(f"{name}.{key}", each) for key, each in data.items()]
    elif isinstance(data, list):
        parts = [(f"{name}[{i}]", each) for i, each in enumerate(data)]
    elif is_number(data) and abs(data) > LARGEST:
        yield f"{name} = {data:g}: must be at most {LARGEST:g}"
    for inner, each in parts:
        yield from _too_large(each, inner)


def _ends(values: float | Mapping[str, float]) -> tuple[float, ...]:
    return (values["start"], values["stop"]) if isinstance(values, Mapping) else (values,)


@cache
def _schema() -> Mapping[str, Any]:
    return json.loads((Path(__file__).parent / "scenario.schema.json").read_bytes())
