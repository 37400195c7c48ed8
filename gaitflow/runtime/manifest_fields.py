"""Readers of a manifest's fields, shared by all formats; every one raises ArtifactError that names the field."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.legacy import modern_name, modern_scenario
from gaitflow.core.task import AXES
from gaitflow.motion.frames import are_frames
from gaitflow.runtime.files import LIMITS, FileEntry
from gaitflow.runtime.json_schema import fault_of
from gaitflow.runtime.manifest import TIME_FORMAT, Gait
from gaitflow.runtime.strict import Fields
from gaitflow.runtime.versions import Version

MAX_GAITS = 4096
MAX_AXIS = 10_000
MAX_TASKS = 10_000_000


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


def _ends(values: float | Mapping[str, float]) -> tuple[float, ...]:
    return (values["start"], values["stop"]) if isinstance(values, Mapping) else (values,)


@cache
def _schema() -> Mapping[str, Any]:
    return json.loads((Path(__file__).parent / "scenario.schema.json").read_bytes())
