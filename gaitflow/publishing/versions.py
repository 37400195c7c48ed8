"""Which versions of a map are published."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from gaitflow.core.errors import ArtifactError
from gaitflow.runtime.manifest_file import read_manifest
from gaitflow.runtime.versions import Version, versions_in


@dataclass(frozen=True)
class Published:
    """One published version: its folder, and when it was made (UTC; None when its manifest cannot be read)."""

    version: Version
    path: Path
    created: datetime | None


def published(folder: Path) -> tuple[Published, ...]:
    """The versions in `models/<scenario>`, oldest number first; a damaged one is listed too."""
    return tuple(_listed(folder / str(version), version) for version in versions_in(folder))


def newest(folder: Path) -> Published | None:
    """The version with the highest number in `models/<scenario>`, or None."""
    found = published(folder)
    return found[-1] if found else None


def _listed(path: Path, version: Version) -> Published:
    try:
        return Published(version, path, read_manifest(path).created)
    except ArtifactError:
        return Published(version, path, None)
