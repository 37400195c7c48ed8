"""Publishing: an artifact appears under its version whole and checked, or not at all, and never changes again."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gaitflow.core.errors import ArtifactError
from gaitflow.files import WriteError, atomic_write, sync_folder
from gaitflow.publishing.card import card
from gaitflow.publishing.parts import Parts, PublishError, content_of, manifest_of
from gaitflow.publishing.verify import inspect
from gaitflow.publishing.versions import newest, next_version
from gaitflow.runtime.files import CARD, MANIFEST
from gaitflow.runtime.manifest import Manifest, encode, parse_manifest, read_manifest
from gaitflow.runtime.versions import Version

# Who made the same content when and under which number does not make it new.
_CIRCUMSTANCES = ("version", "created", "code")
_RACES = 20


class VersionExists(PublishError):
    """The version asked for is taken: a published version never changes."""


def publish(models: Path, parts: Parts, version: str | None = None) -> Path:
    """Publish `models/<scenario>/<version>` and return it.

    Without `version` it is the next free one, or, when the newest version has the same content, that one as it is.
    Raises VersionExists when `version` is taken, PublishError when the parts do not make a sound artifact, ValueError
    when `version` is no version, WriteError when the disk refuses.
    """
    folder = models / parts.problem.scenario.name
    content = content_of(parts)
    if version is not None:
        return _publish(folder, parts, content, Version.parse(version))
    for _ in range(_RACES):
        same = _newest_same(folder, parts, content)
        if same is not None:
            return same
        try:
            return _publish(folder, parts, content, next_version(folder))
        except VersionExists:  # another process took the number meanwhile
            continue
    raise VersionExists(f"{folder}: every next version was taken by others while publishing; publish again")


def _publish(folder: Path, parts: Parts, content: dict[str, bytes], version: Version) -> Path:
    target = folder / str(version)
    _refuse_taken(target)
    files = content | _described(parts, content, version)
    scratch = folder / f".{version}.{os.getpid()}-{secrets.token_hex(4)}"
    try:
        for name in sorted(files, key=lambda name: name == MANIFEST):  # the manifest last
            atomic_write(scratch / name, files[name])
        findings = inspect(scratch)
        if findings:
            raise PublishError("nothing was published:\n" + "\n".join(map(str, findings)))
        _rename(scratch, target)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return target


def _described(parts: Parts, content: dict[str, bytes], version: Version) -> dict[str, bytes]:
    """The card and the manifest."""
    created = datetime.now(UTC)
    text = card(_parsed(manifest_of(parts, {**content, CARD: b""}, version, created))).encode()
    manifest = manifest_of(parts, {**content, CARD: text}, version, created)
    return {CARD: text, MANIFEST: _encoded(manifest)}


def _parsed(data: dict[str, Any]) -> Manifest:
    try:
        return parse_manifest(_encoded(data), MANIFEST)
    except ArtifactError as error:
        raise PublishError(f"nothing was published: {error}") from None


def _encoded(data: dict[str, Any]) -> bytes:
    try:
        return encode(data)
    except (ValueError, TypeError) as error:
        raise PublishError(f"nothing was published: the manifest must be plain JSON without NaN ({error})") from None


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


def _newest_same(folder: Path, parts: Parts, content: dict[str, bytes]) -> Path | None:
    """The newest version when it is sound and holds this content."""
    last = newest(folder)
    if last is None or last.created is None or inspect(last.path):
        return None
    old = read_manifest(last.path)
    new = _parsed(manifest_of(parts, {**content, CARD: b""}, old.version, old.created))
    return last.path if _comparable(old) == _comparable(new) else None


def _comparable(manifest: Manifest) -> dict[str, Any]:
    kept = {name: value for name, value in vars(manifest).items() if name not in _CIRCUMSTANCES}
    return kept | {"files": {name: entry for name, entry in manifest.files.items() if name != CARD}}
