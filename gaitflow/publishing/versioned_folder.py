"""One folder a version, for datasets and maps: it appears whole, lists a digest of every file, and never changes."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from gaitflow.core.errors import ArtifactError
from gaitflow.files import WriteError, atomic_write, sync_folder
from gaitflow.runtime.files import MANIFEST, FileEntry, entry_of, read_limited
from gaitflow.runtime.versions import Version, versions_in

_RACES = 20


class PublishError(RuntimeError):
    """What was to be published is not sound: names each fault. Nothing was published."""


class VersionExists(PublishError):
    """The version asked for is taken: a published version never changes."""


@dataclass(frozen=True)
class Finding:
    """One fault of a published folder: the file it is in, and what is wrong."""

    file: str
    fault: str

    def __str__(self) -> str:
        return f"{self.file}: {self.fault}"


def publish_folder(
    parent: Path,
    version: str,
    files: Mapping[str, bytes],
    inspect: Callable[[Path], Iterable[object]] = lambda folder: (),
) -> Path:
    """Publish `files` as `parent/version` and return that folder; the manifest is written last.

    `inspect` looks at the finished files before they get their name, and lists what is wrong with them. Raises
    VersionExists when the version is taken, PublishError when `inspect` finds a fault, ValueError when `version` is no
    version, WriteError when the disk refuses. Nothing is left behind then.
    """
    target = parent / str(Version.parse(version))
    _refuse_taken(target)
    scratch = parent / f".{version}.{os.getpid()}-{secrets.token_hex(4)}"
    try:
        for name in sorted(files, key=lambda name: (name == MANIFEST, name)):
            atomic_write(scratch / name, files[name])
        findings = list(inspect(scratch))
        if findings:
            raise PublishError("nothing was published:\n" + "\n".join(map(str, findings)))
        _rename(scratch, target)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return target


def publish_next(parent: Path, make: Callable[[str], Path]) -> Path:
    """What `make` publishes under the next free version of `parent`, which it is given.

    Of several processes each gets a version of its own. Raises VersionExists when others take every one.
    """
    for _ in range(_RACES):
        try:
            return make(str(next_version(parent)))
        except VersionExists:  # another process took the number meanwhile
            continue
    raise VersionExists(f"{parent}: every next version was taken by others while publishing; publish again")


def next_version(parent: Path) -> Version:
    """1.0.0, then the next minor version of the newest: the content changed, how it is read did not."""
    versions = versions_in(parent)
    return Version(versions[-1].major, versions[-1].minor + 1, 0) if versions else Version(1, 0, 0)


def listed(files: Mapping[str, bytes]) -> dict[str, dict[str, str | int]]:
    """The entry of each file in a manifest: its SHA-256 and its size."""
    return {name: asdict(entry_of(content)) for name, content in sorted(files.items())}


def file_faults(folder: Path, entries: Mapping[str, FileEntry]) -> list[Finding]:
    """What is missing, foreign or damaged in a folder whose manifest lists `entries`, every file but itself."""
    found = {path.name for path in folder.iterdir()}
    faults = [
        Finding(name, "does not belong to the published files; remove it")
        for name in sorted(found - {MANIFEST, *entries})
    ]
    for name, entry in sorted(entries.items()):
        try:
            content = read_limited(folder / name, entry.bytes)
        except ArtifactError as error:
            faults.append(Finding(name, str(error).removeprefix(f"{folder / name}: ")))
            continue
        if entry_of(content) != entry:
            faults.append(
                Finding(name, "its content is not what the manifest lists (SHA-256 or size differs): it is damaged")
            )
    return faults


def _refuse_taken(target: Path) -> None:
    if target.exists() or target.is_symlink():
        raise VersionExists(
            f"{target} is published already and never changes; leave the version out to take the next free one, "
            "or give a higher one"
        )


def _rename(scratch: Path, target: Path) -> None:
    """Give the finished folder its name; of several writers one wins, and the name is durable."""
    try:
        os.rename(scratch, target)
        sync_folder(target.parent)
    except OSError as error:
        if error.errno in (errno.ENOTEMPTY, errno.EEXIST):
            _refuse_taken(target)
        raise WriteError(error.errno or errno.EIO, f"{target}: cannot be written ({error.strerror})") from None
