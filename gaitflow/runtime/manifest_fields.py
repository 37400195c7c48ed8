"""Readers of a manifest's fields, shared by all formats; every one raises ArtifactError that names the field."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import Layout
from gaitflow.core.legacy import modern_name, modern_scenario
from gaitflow.core.task import AXES
from gaitflow.motion.frames import are_frames
from gaitflow.runtime.files import LIMITS, FileEntry
from gaitflow.runtime.manifest import TIME_FORMAT, Gait
from gaitflow.runtime.strict import Fields, is_number
from gaitflow.runtime.versions import Version

MAX_GAITS = 4096
MAX_AXIS = 10_000
MAX_TASKS = 10_000_000
_PARTS = ("robot", "objective", "transcription", "tasks")


def version(fields: Fields) -> Version:
    """The artifact's version."""
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
    """The scenario in today's form; what the runtime itself reads of it is checked, sizes above all."""
    try:
        data = modern_scenario(fields.mapping("scenario"))
    except ValueError as error:
        fields.refuse("scenario", str(error))
    if not isinstance(data.get("name"), str) or not all(isinstance(data.get(part), dict) for part in _PARTS):
        fields.refuse("scenario", f"a scenario with name, {', '.join(_PARTS)}")
    robot, transcription, legs = data["robot"], data["transcription"], data["robot"].get("legs")
    clearance = data.get("swing_clearance", 0.0)
    sound = {
        "robot.dimension": robot.get("dimension") in (2, 3),
        "robot.mass": is_number(robot.get("mass")) and robot["mass"] > 0,
        "robot.legs": isinstance(legs, list) and 1 <= len(legs) <= 8 and all(map(_is_leg, legs)),
        "robot.frames": robot.get("frames") is None or are_frames(robot["frames"], legs),
        "transcription.phases": _is_count(transcription.get("phases"), 64),
        "transcription.knots_per_phase": _is_count(transcription.get("knots_per_phase"), 1000),
        "transcription.forces": transcription.get("forces") in ("held", "linear"),
        "transcription.grading": is_number(transcription.get("grading")) and 0 <= transcription["grading"] <= 1,
        "swing_clearance": is_number(clearance) and 0 <= clearance < 1,
        "tasks.axes": _are_axes(data["tasks"]["axes"]),
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


def _is_leg(leg: object) -> bool:
    return isinstance(leg, dict) and isinstance(leg.get("name"), str) and 0 < len(leg["name"]) <= 80


def _is_count(value: object, most: int) -> bool:
    return type(value) is int and 1 <= value <= most


def _are_axes(axes: Mapping[str, Any]) -> bool:
    ranged = [axis for axis, values in axes.items() if isinstance(values, dict)]
    fixed = [axis for axis in axes if axis not in ranged]
    return (
        bool(ranged)
        and set(axes) <= set(AXES)
        and all(is_number(axes[axis]) and AXES[axis].admits(axes[axis]) for axis in fixed)
        and ("cycle_duration" in axes)
    )
