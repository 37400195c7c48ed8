"""Publishing a map as `models/<scenario>/<version>`: whole and checked, or not at all."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gaitflow.core.errors import ArtifactError
from gaitflow.publishing.card import card
from gaitflow.publishing.parts import Parts, content_of, manifest_of
from gaitflow.publishing.verify_map import inspect
from gaitflow.publishing.versioned_folder import PublishError, publish_folder, publish_next
from gaitflow.publishing.versions import newest
from gaitflow.runtime.files import CARD, MANIFEST
from gaitflow.runtime.manifest import Manifest, encode
from gaitflow.runtime.manifest_file import parse_manifest, read_manifest
from gaitflow.runtime.versions import Version

# Who made the same content when and under which number does not make it new.
_CIRCUMSTANCES = ("version", "created", "code")


def publish(models: Path, parts: Parts, version: str | None = None) -> Path:
    """Publish `models/<scenario>/<version>` and return it.

    Without `version` it is the next free one, or, when the newest version has the same content, that one as it is.
    Raises VersionExists when `version` is taken, PublishError when the parts do not make a sound artifact, ValueError
    when `version` is no version, WriteError when the disk refuses.
    """
    folder, content = models / parts.problem.scenario.name, content_of(parts)

    def publish_as(number: str) -> Path:
        files = content | _described(parts, content, Version.parse(number))
        return publish_folder(folder, number, files, inspect)

    if version is not None:
        return publish_as(version)
    return _newest_same(folder, parts, content) or publish_next(folder, publish_as)


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
    domain = {axis: list(values) for axis, values in manifest.domain.axes.items()}, manifest.domain.feasible.tolist()
    files = {name: entry for name, entry in manifest.files.items() if name != CARD}
    return kept | {"domain": domain, "files": files}
