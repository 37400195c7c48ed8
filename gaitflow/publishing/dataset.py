"""Publishing a dataset as `datasets/<scenario>/<version>`, small enough to be kept with the code."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd

from gaitflow.core.errors import ArtifactError
from gaitflow.dataset.read import FILE_NAME, load_solutions
from gaitflow.dataset.thin import thin
from gaitflow.publishing.dataset_card import KEPT_DEARER, KEPT_GAITS, dataset_card
from gaitflow.publishing.dataset_facts import GAIT_COSTS, LABELS, dataset_facts
from gaitflow.publishing.versioned_folder import listed, publish_folder, publish_next
from gaitflow.runtime.files import CARD, MANIFEST, FileEntry, read_limited
from gaitflow.runtime.manifest import TIME_FORMAT
from gaitflow.runtime.versions import versions_in
from gaitflow.tables.schema import task_columns

FILES = (FILE_NAME, LABELS, GAIT_COSTS, CARD)  # every file but the manifest
FORMAT = 1
MAX_MANIFEST_BYTES = 1_000_000
LARGE = 20_000_000  # bytes of solutions from which on fewer motions are kept
FEWER_TASKS = (0.7, 0.5, 0.3, 0.1)  # shares of the tasks that keep motions, once they keep one each


@dataclass(frozen=True)
class DatasetManifest:
    """What a published dataset's manifest says: `content` is a digest of what was solved and labelled."""

    scenario: str
    version: str
    created: str
    content: str
    files: dict[str, FileEntry]


def read_manifest(folder: Path) -> DatasetManifest:
    """The manifest of a published dataset. Raises ValueError that names the file when it is not one we read."""
    path = folder / MANIFEST
    try:
        data = json.loads(read_limited(path, MAX_MANIFEST_BYTES))
        number = data["format"]
        if number == FORMAT:
            texts = {name: str(data[name]) for name in ("scenario", "version", "created", "content")}
            files = {str(name): FileEntry(str(one["sha256"]), int(one["bytes"])) for name, one in data["files"].items()}
            return DatasetManifest(**texts, files=files)
    except (ArtifactError, ValueError, KeyError, TypeError, AttributeError):
        raise ValueError(f"{path}: no readable manifest; is {folder} a published dataset?") from None
    raise ValueError(f"{path}: has format {number!r}; this version of gaitflow reads {FORMAT}, update it")


def publish_dataset(
    datasets: Path, collected: Path, labels: Path, gait_costs: Path, version: str | None = None
) -> Path:
    """Publish `datasets/<scenario>/<version>` and return it.

    Without `version` it is the next free one, or, when the newest version has the same content, that one as it is. The
    collected solutions are thinned (see `gaitflow.dataset.thin`), the other files copied. Raises VersionExists
    when `version` is taken, ValueError when a file is not what it should be, WriteError when the disk refuses.
    """
    solutions = load_solutions(collected)
    record, frame = solutions.record, pd.read_parquet(labels)
    folder = datasets / record["scenario"]["name"]
    content = content_digest(record, frame)
    if version is None and (same := _newest_same(folder, content)) is not None:
        return same
    small = _thinned(collected, pd.read_parquet(gait_costs))
    files = {FILE_NAME: small, LABELS: labels.read_bytes(), GAIT_COSTS: gait_costs.read_bytes()}

    def publish(number: str) -> Path:
        created = datetime.now(UTC).strftime(TIME_FORMAT)
        described = files | {CARD: dataset_card(dataset_facts(number, created, files)).encode()}
        manifest = {
            "format": FORMAT,
            "scenario": folder.name,
            "version": number,
            "created": created,
            "content": content,
            "files": listed(described),
        }
        return publish_folder(folder, number, described | {MANIFEST: _json(manifest)})

    return publish_next(folder, publish) if version is None else publish(version)


def _thinned(collected: Path, costs: pd.DataFrame) -> bytes:
    """The solutions with the motions of as many gaits a task, then of as many tasks, as make no large file."""
    ways = [*((gaits, 1.0) for gaits in range(KEPT_GAITS, 0, -1)), *((1, share) for share in FEWER_TASKS)]
    with TemporaryDirectory(dir=collected.parent) as scratch:
        for gaits, tasks in ways:
            small = thin(collected, Path(scratch) / FILE_NAME, costs, gaits, KEPT_DEARER, tasks).read_bytes()
            if len(small) <= LARGE:
                break
    return small


def content_digest(record: Mapping[str, Any], labels: pd.DataFrame) -> str:
    """What makes two datasets the same: the units solved, what the labels say of them, and the askings so far.

    When and where does not count. Nor do numbers: they follow from the units, but for their last digits, which differ
    between machines.
    """
    columns = [*task_columns(labels.columns), "status", "gait", "pattern", "runner_up", "resolved", "label"]
    askings = f"askings {record['askings']}" if "askings" in record else ""
    text = record["units_digest"] + askings + labels[columns].to_csv(index=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _newest_same(folder: Path, content: str) -> Path | None:
    """The newest version when it holds this content."""
    versions = versions_in(folder)
    if not versions:
        return None
    newest = folder / str(versions[-1])
    return newest if read_manifest(newest).content == content else None


def _json(data: Any) -> bytes:
    return (json.dumps(data, indent=1, sort_keys=True) + "\n").encode()
