"""map.bin: all of a map but its problem, as one little-endian file that any language reads in order.

docs/other-languages.md describes it byte by byte; gaitflow/export/cpp/map_file.hpp reads it.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Sequence
from itertools import chain

from gaitflow.core.domain import Domain
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES
from gaitflow.core.task_space import TaskSpace
from gaitflow.export.classifier_data import ClassifierData
from gaitflow.export.items import array, counts, text
from gaitflow.runtime.artifact import Artifact
from gaitflow.runtime.atlas import DOUBT, SUPPORT, Atlas
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.nearby import NEAREST, REACH
from gaitflow.runtime.tensors import GaitTensors
from gaitflow.solvers.point import GaitSpace

MAGIC = b"gaitmap\n"
FORMAT = 7
_START = struct.Struct("<8sIIQ32s")  # magic, format, CRC-32 of all from byte 16 on, size of the file, digest


def map_bytes(artifact: Artifact, digest: bytes, classifier: ClassifierData) -> bytes:
    """The file's content; `digest` [32] is the SHA-256 of manifest.json. Equal maps give equal bytes."""
    manifest, tensors = artifact.manifest, artifact.tensors
    legs = [str(leg["name"]) for leg in manifest.scenario["robot"]["legs"]]
    items = chain(
        [text(manifest.name), text(str(manifest.version))],
        _axes(manifest.space),
        _domain(manifest.domain),
        _layout(manifest.layout, legs, tensors.rows),
        [array([manifest.cost_scale], "<f8")],
        classifier.items(),
        _gaits(manifest, tensors),
        _atlas(artifact.atlas),
    )
    body = b"".join(items)
    size = _START.size + len(body)
    checked = _START.pack(MAGIC, FORMAT, 0, size, digest)[16:] + body
    return _START.pack(MAGIC, FORMAT, zlib.crc32(checked), size, digest) + body


def _axes(space: TaskSpace) -> Iterator[bytes]:
    """Every parameter of a task with the value that the map holds it at, 0 for those that it ranges over."""
    names, fixed = list(AXES), dict(space.fixed)
    held = [0.0 if name in space.ranged else fixed.get(name, AXES[name].default or 0.0) for name in names]
    yield counts(len(names), len(space.ranged))
    yield from map(text, names)
    yield array(held, "<f8")
    yield counts(*(names.index(axis) for axis in space.ranged))


def _domain(domain: Domain) -> Iterator[bytes]:
    yield counts(*map(len, domain.axes.values()))
    yield from (array(values, "<f8") for values in domain.axes.values())
    yield array(domain.feasible, "u1")


def _layout(layout: Layout, legs: Sequence[str], rows: int) -> Iterator[bytes]:
    sizes = layout.phases, layout.knots_per_phase, layout.legs, layout.dimension, layout.nb, rows
    yield counts(*sizes, int(layout.linear_forces), int(layout.energy))
    yield from map(text, legs)
    yield array(layout.shares, "<f8")
    yield array(layout.scale(1.0), "<f8")


def _gaits(manifest: Manifest, tensors: GaitTensors) -> Iterator[bytes]:
    yield counts(len(manifest.gaits))
    for index, gait in enumerate(manifest.gaits):
        yield from map(text, (gait.name, gait.key, gait.pattern))
        yield from (array(vector, "<f8") for vector in tensors.mean(index))
        yield from _space(tensors.space(index))


def _atlas(atlas: Atlas) -> Iterator[bytes]:
    yield array(atlas.steps, "<f8")
    yield array([atlas.barrier, REACH, NEAREST, SUPPORT, DOUBT], "<f8")
    yield counts(len(atlas.sheets))
    for sheet in atlas.sheets:
        yield counts(sheet.gait)
        yield text(sheet.pattern)
        yield from _space(sheet.space)
        yield counts(len(sheet.tasks), *sheet.modes.shape, len(sheet.infeasible))
        yield array([sheet.tear], "<f8")
        yield from (array(each, "<f8") for each in (sheet.tasks, sheet.infeasible, sheet.costs, sheet.slopes))
        yield from (array(each, "<f4") for each in (sheet.mean, sheet.modes, sheet.coordinates, sheet.tangents))


def _space(space: GaitSpace) -> Iterator[bytes]:
    return (array(each, "<f8") for each in (space.lower, space.upper, space.lower_rows, space.upper_rows))
