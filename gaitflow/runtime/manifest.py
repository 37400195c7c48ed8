"""What a map says of itself, as data; `manifest_file` reads it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Any

from gaitflow.core.domain import Domain
from gaitflow.core.layout import Layout
from gaitflow.core.task_space import TaskSpace
from gaitflow.runtime.files import FileEntry
from gaitflow.runtime.versions import Version

FORMAT = 3
TIME_FORMAT = "%Y-%m-%dT%H:%M:%SZ"
SELF_DIGEST = "manifest_sha256"


@dataclass(frozen=True)
class Gait:
    """A gait of the map: display name, canonical text, and the pattern that its problem imposes."""

    name: str
    key: str
    pattern: str


@dataclass(frozen=True)
class Manifest:
    """A checked manifest. `gaits` are in the classifier's output order; a stored cost is the problem's * `cost_scale`.

    `scenario` is the scenario's whole JSON in today's form, `scenario_digest` the SHA-256 of the JSON that was
    published; `created` is UTC; `dataset` names what the map was learnt from (name, version); `code` what made it;
    `metrics` are the published classifier's; `solver_options` are IPOPT's options of a refining solve.
    """

    format: int
    version: Version
    scenario: Mapping[str, Any]
    scenario_digest: str
    created: datetime
    dataset: Mapping[str, Any]
    code: Mapping[str, Any]
    domain: Domain
    gaits: tuple[Gait, ...]
    cost_scale: float
    classifier_kind: str
    metrics: Mapping[str, Any]
    solver_options: Mapping[str, float | int | str]
    files: Mapping[str, FileEntry]

    @property
    def name(self) -> str:
        """The scenario's name."""
        return str(self.scenario["name"])

    @cached_property
    def layout(self) -> Layout:
        """Where states, controls and durations sit in a decision vector."""
        return Layout.of(self.scenario)

    @cached_property
    def space(self) -> TaskSpace:
        """The axes of the map's tasks."""
        return TaskSpace.of(self.scenario)

    @property
    def gaitflow_version(self) -> str:
        """The version of gaitflow that published it, "unknown" where it does not say."""
        code = self.code.get("code")
        version = code.get("version") if isinstance(code, Mapping) else None
        return str(version)[:80] if version is not None else "unknown"


def encode(data: Mapping[str, Any]) -> bytes:
    """The one text of a manifest: sorted fields, with the SHA-256 of the rest as `manifest_sha256`.

    Raises ValueError for a number that JSON cannot hold (NaN, inf) and TypeError for what is not plain data.
    """
    rest = {key: value for key, value in data.items() if key != SELF_DIGEST}
    digest = hashlib.sha256(_text(rest)).hexdigest()
    return _text({**rest, SELF_DIGEST: digest})


def _text(data: Mapping[str, Any]) -> bytes:
    return (json.dumps(data, sort_keys=True, indent=1, allow_nan=False) + "\n").encode()
