"""manifest.json, checked field by field without a validation library."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gaitflow.core.domain import Domain
from gaitflow.core.errors import ArtifactError
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXES, span
from gaitflow.core.task_space import TaskSpace
from gaitflow.runtime import legacy
from gaitflow.runtime.files import CONTENT, LIMITS, MANIFEST, read_limited
from gaitflow.runtime.manifest import FORMAT, SELF_DIGEST, Manifest, encode
from gaitflow.runtime.manifest_fields import (
    MAX_AXIS,
    created,
    feasible,
    file_entries,
    gaits,
    scenario,
    solver_options,
    version,
)
from gaitflow.runtime.strict import Fields

_FIELDS = (
    "format", "version", "scenario", "scenario_digest", "created", "dataset", "code", "domain", "gaits", "cost_scale",
    "classifier", "metrics", "solver", "files", SELF_DIGEST,
)  # fmt: skip


def read_manifest(folder: Path) -> Manifest:
    """The manifest of the artifact in `folder`. Raises ArtifactError when it is missing, damaged, or not understood."""
    path = folder / MANIFEST
    return parse_manifest(read_limited(path, LIMITS[MANIFEST]), str(path))


def parse_manifest(content: bytes, where: str) -> Manifest:
    """The manifest in a file's bytes; `where` is what errors call the file. Raises ArtifactError."""
    try:
        data = json.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise ArtifactError(f"{where}: not JSON ({str(error)[:200]}); copy the map again") from None
    if not isinstance(data, dict):
        raise ArtifactError(f"{where}: expected an object, found {type(data).__name__}; this is no gaitflow artifact")
    found = data.get("format")
    if type(found) is int and found > FORMAT:
        raise ArtifactError(
            f"{where}: the map has format {found}, this gaitflow reads format 1 to {FORMAT}: "
            "update gaitflow, or use a map that this version published"
        )
    if type(found) is not int or found < 1:
        raise ArtifactError(f"{where}: format = {str(found)[:80]!r}: this gaitflow reads format 1 to {FORMAT}")
    if not _is_encoded(data, content):
        raise ArtifactError(
            f"{where}: its content does not have the SHA-256 that it states: it is damaged or was edited; "
            "copy the map again or publish a new version"
        )
    return legacy.manifest(data, where) if found < FORMAT else _manifest(Fields(data, where, _FIELDS))


def _is_encoded(data: dict[str, Any], content: bytes) -> bool:
    try:
        return encode(data) == content
    except (ValueError, RecursionError):
        return False


def _manifest(fields: Fields) -> Manifest:
    checked = scenario(fields)
    dataset = fields.inner("dataset", ("name", "version"))
    return Manifest(
        format=fields.integer("format", FORMAT, FORMAT),
        version=version(fields),
        scenario=checked,
        scenario_digest=fields.digest("scenario_digest"),
        created=created(fields),
        dataset={name: dataset.text(name) for name in ("name", "version")},
        code=fields.mapping("code"),
        domain=_domain(fields.inner("domain", ("axes", "feasible")), TaskSpace.of(checked)),
        gaits=gaits(fields, Layout.of(checked)),
        cost_scale=fields.positive("cost_scale"),
        classifier_kind=fields.inner("classifier", ("kind",)).text("kind"),
        metrics=fields.mapping("metrics"),
        solver_options=solver_options(fields),
        files=file_entries(fields.inner("files", CONTENT), CONTENT),
    )


def _domain(fields: Fields, space: TaskSpace) -> Domain:
    axes = fields.inner("axes", space.ranged)
    values = {axis: axes.rising(axis, MAX_AXIS) for axis in space.ranged}
    for axis, own in values.items():
        if not AXES[axis].admits(own[0]) or not AXES[axis].admits(own[-1]):
            axes.refuse(axis, f"values in {span(axis)}")
    return Domain(values, feasible(fields, tuple(map(len, values.values()))))
