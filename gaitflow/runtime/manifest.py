"""manifest.json: what an artifact is, checked field by field without a validation library."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from gaitflow.core.domain import Domain
from gaitflow.core.errors import ArtifactError
from gaitflow.core.gaits import Pattern
from gaitflow.runtime.files import (
    ATLAS,
    CARD,
    CLASSIFIER,
    LIMITS,
    MANIFEST,
    PROBLEM,
    WARM_STARTS,
    FileEntry,
    read_limited,
)
from gaitflow.runtime.layout import Layout
from gaitflow.runtime.strict import Fields
from gaitflow.runtime.versions import Version
from gaitflow.solvers.options import checked_options

FORMAT = 2
TIME_FORMAT = "%Y-%m-%dT%H:%M:%SZ"
CONTENT = (CARD, CLASSIFIER, PROBLEM, WARM_STARTS, ATLAS)  # every file of an artifact but the manifest
_OLDER = {1: (CARD, CLASSIFIER, PROBLEM, WARM_STARTS)}  # maps without an atlas: plans start at a region's mean
SELF_DIGEST = "manifest_sha256"
MAX_GAITS = 4096
MAX_AXIS = 10_000

_FIELDS = (
    "format", "version", "scenario", "scenario_digest", "created", "dataset", "code", "domain", "gaits", "layout",
    "cost_scale", "classifier", "metrics", "solver", "files", SELF_DIGEST,
)  # fmt: skip


@dataclass(frozen=True)
class Gait:
    """A gait of the map: display name, canonical text, and the full pattern that its problem imposes."""

    name: str
    key: str
    pattern: str


@dataclass(frozen=True)
class Manifest:
    """A checked manifest. `gaits` are in the classifier's output order; a stored cost is the problem's * `cost_scale`.

    `scenario` is the scenario's whole JSON, `scenario_digest` its SHA-256; `created` is UTC; `metrics` are the
    published classifier's; `solver_options` are IPOPT's options of a refining solve.
    """

    version: Version
    scenario: Mapping[str, Any]
    scenario_digest: str
    created: datetime
    dataset: Mapping[str, Any]
    code: Mapping[str, Any]
    domain: Domain
    gaits: tuple[Gait, ...]
    layout: Layout
    cost_scale: float
    classifier_kind: str
    metrics: Mapping[str, Any]
    solver_options: Mapping[str, float | int | str]
    files: Mapping[str, FileEntry]

    @property
    def name(self) -> str:
        """The scenario's name."""
        return str(self.scenario["name"])


def encode(data: Mapping[str, Any]) -> bytes:
    """The one text of a manifest: sorted fields, with the SHA-256 of the rest as `manifest_sha256`.

    Raises ValueError for a number that JSON cannot hold (NaN, inf) and TypeError for what is not plain data.
    """
    rest = {key: value for key, value in data.items() if key != SELF_DIGEST}
    digest = hashlib.sha256(_text(rest)).hexdigest()
    return _text({**rest, SELF_DIGEST: digest})


def _text(data: Mapping[str, Any]) -> bytes:
    return (json.dumps(data, sort_keys=True, indent=1, allow_nan=False) + "\n").encode()


def read_manifest(folder: Path) -> Manifest:
    """The manifest of the artifact in `folder`. Raises ArtifactError when it is missing, damaged, or not understood."""
    path = folder / MANIFEST
    return parse_manifest(read_limited(path, LIMITS[MANIFEST]), str(path))


def parse_manifest(content: bytes, where: str) -> Manifest:
    """The manifest in a file's bytes; `where` is what errors call the file. Raises ArtifactError."""
    try:
        data = json.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise ArtifactError(f"{where}: not JSON ({str(error)[:200]}); copy the artifact again") from None
    if not isinstance(data, dict):
        raise ArtifactError(f"{where}: expected an object, found {type(data).__name__}; this is no gaitflow artifact")
    found = data.get("format")
    if type(found) is int and found > FORMAT:
        raise ArtifactError(
            f"{where}: the artifact has format {found}, this gaitflow reads format 1 to {FORMAT}: "
            "update gaitflow, or use an artifact that this version published"
        )
    if type(found) is not int or found not in (FORMAT, *_OLDER):
        raise ArtifactError(f"{where}: format = {str(found)[:80]!r}: this gaitflow reads format 1 to {FORMAT}")
    if not _is_encoded(data, content):
        raise ArtifactError(
            f"{where}: its content does not have the SHA-256 that it states: it is damaged or was edited; "
            "copy the artifact again or publish a new version"
        )
    return _manifest(Fields(data, where, _FIELDS), _OLDER.get(found, CONTENT))


def _is_encoded(data: dict[str, Any], content: bytes) -> bool:
    try:
        return encode(data) == content
    except (ValueError, RecursionError):
        return False


def _manifest(fields: Fields, content: tuple[str, ...]) -> Manifest:
    layout = _layout(fields.inner("layout", (
        "phases", "knots_per_phase", "legs", "dimension", "base", "variables", "rows", "duration_slice",
    )))  # fmt: skip
    return Manifest(
        version=_version(fields),
        scenario=_scenario(fields),
        scenario_digest=fields.digest("scenario_digest"),
        created=_created(fields),
        dataset=fields.mapping("dataset"),
        code=fields.mapping("code"),
        domain=_domain(fields.inner("domain", ("speed", "cycle_duration", "feasible"))),
        gaits=_gaits(fields, layout),
        layout=layout,
        cost_scale=fields.positive("cost_scale"),
        classifier_kind=fields.inner("classifier", ("kind",)).text("kind"),
        metrics=fields.mapping("metrics"),
        solver_options=checked_options(fields.inner("solver", ("options",)).mapping("options")),
        files=_files(fields.inner("files", content), content),
    )


def _version(fields: Fields) -> Version:
    try:
        return Version.parse(fields.text("version"))
    except ValueError as error:
        fields.refuse("version", str(error))


def _scenario(fields: Fields) -> Mapping[str, Any]:
    scenario = fields.mapping("scenario")
    parts = ("robot", "terrain", "objective", "transcription", "tasks")
    if not isinstance(scenario.get("name"), str) or not all(isinstance(scenario.get(part), dict) for part in parts):
        fields.refuse("scenario", f"a scenario with name, {', '.join(parts)}")
    return scenario


def _created(fields: Fields) -> datetime:
    try:
        return datetime.strptime(fields.text("created") + "+0000", TIME_FORMAT + "%z")
    except ValueError:
        fields.refuse("created", "UTC such as 2026-01-31T12:00:00Z")


def _domain(fields: Fields) -> Domain:
    speeds, durations = fields.rising("speed", MAX_AXIS), fields.rising("cycle_duration", MAX_AXIS)
    rows = fields.items("feasible", len(speeds))
    right = len(rows) == len(speeds) and all(isinstance(row, list) and len(row) == len(durations) for row in rows)
    if not right or not all(type(cell) is bool for row in rows for cell in row):
        fields.refuse("feasible", f"{len(speeds)} rows (speeds) of {len(durations)} booleans (cycle durations)")
    return Domain(speeds, durations, tuple(map(tuple, rows)))


def _gaits(fields: Fields, layout: Layout) -> tuple[Gait, ...]:
    gaits = tuple(
        _gait(Fields(item, f"gaits[{index}]", ("name", "key", "pattern")), layout)
        for index, item in enumerate(fields.items("gaits", MAX_GAITS))
    )
    if len({gait.name for gait in gaits}) < len(gaits) or len({gait.key for gait in gaits}) < len(gaits):
        fields.refuse("gaits", "gaits of different names and keys")
    return gaits


def _gait(fields: Fields, layout: Layout) -> Gait:
    for name in ("key", "pattern"):
        try:
            pattern = Pattern.from_text(fields.text(name))
        except ValueError as error:
            fields.refuse(name, str(error))
        fits = pattern.phases == layout.phases if name == "pattern" else pattern.phases <= layout.phases
        if pattern.legs != len(layout.legs) or not fits:
            shape = f"{len(layout.legs)} legs and {layout.phases} phases"
            fields.refuse(name, f"a pattern of {shape} (a key may have fewer phases)")
    return Gait(fields.text("name"), fields.text("key"), fields.text("pattern"))


def _layout(fields: Fields) -> Layout:
    legs = fields.items("legs", 8)
    if not all(isinstance(leg, str) and 0 < len(leg) <= 8 for leg in legs):
        fields.refuse("legs", "names of legs")
    layout = Layout(
        phases=fields.integer("phases", 1, 64),
        knots_per_phase=fields.integer("knots_per_phase", 1, 1000),
        legs=tuple(legs),
        dimension=fields.integer("dimension", 2, 3),
        base=fields.integer("base", 1, 100),
        rows=fields.integer("rows", 1, 10_000_000),
    )
    fields.integer("variables", layout.variables, layout.variables)
    if tuple(fields.items("duration_slice", 2)) != layout.duration_slice:
        fields.refuse("duration_slice", f"{list(layout.duration_slice)}, the last {layout.phases} variables")
    return layout


def _files(fields: Fields, content: tuple[str, ...]) -> Mapping[str, FileEntry]:
    entries = {}
    for name in content:
        entry = fields.inner(name, ("sha256", "bytes"))
        entries[name] = FileEntry(entry.digest("sha256"), entry.integer("bytes", 0, LIMITS[name]))
    return entries
