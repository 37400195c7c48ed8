"""Versions of a map: folders `models/<scenario>/<major>.<minor>.<patch>/`, in semantic order."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from gaitflow.core.errors import ArtifactError

_NUMBER = r"(0|[1-9][0-9]{0,8})"
_VERSION = re.compile(rf"{_NUMBER}\.{_NUMBER}\.{_NUMBER}")


class Version(NamedTuple):
    """A semantic version without pre-release or build parts; tuples compare as versions do (1.10.0 > 1.9.0)."""

    major: int
    minor: int
    patch: int

    @classmethod
    def parse(cls, text: str) -> Version:
        """Raises ValueError unless `text` is `<major>.<minor>.<patch>`, such as 1.0.0."""
        match = _VERSION.fullmatch(text)
        if match is None:
            raise ValueError(f"version {text[:80]!r}: write <major>.<minor>.<patch>, such as 1.0.0, no leading zeros")
        return cls(*(int(part) for part in match.groups()))

    def __str__(self) -> str:
        return f"{self.major}.{self.minor}.{self.patch}"


def versions_in(folder: Path) -> tuple[Version, ...]:
    """The versions published in a scenario's folder, oldest first; empty when there is no such folder."""
    if not folder.is_dir():
        return ()
    names = (entry.name for entry in folder.iterdir() if entry.is_dir())
    return tuple(sorted(Version.parse(name) for name in names if _VERSION.fullmatch(name)))


def newest_of(names: Iterable[str]) -> Version | None:
    """The highest of the names that are versions, None when none is."""
    return max((Version.parse(name) for name in names if _VERSION.fullmatch(name)), default=None)


def resolve(path: Path) -> Path:
    """The folder of one version: `path` itself when it holds a manifest, else its newest version.

    Raises ArtifactError when there is neither, and for a dataset.
    """
    if (path / "manifest.json").exists() or _VERSION.fullmatch(path.name):
        return _no_dataset(path)
    versions = versions_in(path)
    if not versions:
        raise ArtifactError(
            f"{path}: no map here: expected manifest.json, or version folders such as 1.0.0; "
            "`gaitflow publish` makes them"
        )
    return _no_dataset(path / str(versions[-1]))


def _no_dataset(folder: Path) -> Path:
    if (folder / "solutions.parquet").exists():
        raise ArtifactError(f"{folder}: is a dataset, not a map; give a map's folder such as models/<scenario>")
    return folder
