"""Publishing a version at an address that fsspec knows: whole, read back, its manifest last, never over another one."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from gaitflow.publishing.find import is_dataset
from gaitflow.publishing.versioned_folder import PublishError, VersionExists, file_faults
from gaitflow.runtime.files import MANIFEST, FileEntry, entry_of
from gaitflow.runtime.manifest_file import read_manifest


def upload(folder: Path, address: str) -> str:
    """Copy the version in `folder` to `address`/<scenario>/<version> and return where that is.

    Its files are checked first, and read back from there before the manifest follows: who loads the version meanwhile
    finds nothing. Raises VersionExists when the version is there already, PublishError when a file is damaged, here or
    on its way, or the address refuses, ValueError and ArtifactError when the manifest cannot be read.
    """
    from fsspec.core import url_to_fs

    name, version, entries = _listed(folder)
    if faults := file_faults(folder, entries):
        raise PublishError("nothing was published:\n" + "\n".join(map(str, faults)))
    target = f"{address.rstrip('/')}/{name}/{version}"
    try:
        system, root = url_to_fs(target)
        if system.exists(f"{root}/{MANIFEST}"):
            raise VersionExists(f"{target} is published already and never changes; publish a higher version")
        bucket = root.split("/", 1)[0]  # nothing where paths begin with /
        if bucket and not system.exists(bucket):  # makedirs would make one of a mistyped name
            raise PublishError(f"{target}: cannot be written (there is no bucket {bucket}); make it first")
        system.makedirs(root, exist_ok=True)
        for file, entry in sorted(entries.items()):
            _send(system, folder / file, f"{root}/{file}", entry, target)
        _send(system, folder / MANIFEST, f"{root}/{MANIFEST}", entry_of((folder / MANIFEST).read_bytes()), target)
    except PublishError:
        raise
    except Exception as error:  # every file system raises errors of its own
        told = " ".join(str(error).split()) or type(error).__name__
        raise PublishError(f"{target}: cannot be written ({told[:300]})") from None
    return target


def _send(system: Any, source: Path, place: str, entry: FileEntry, target: str) -> None:
    """Write one file and read it back. Raises PublishError and removes it when it is not what was sent."""
    system.pipe_file(place, source.read_bytes())
    sound = False
    try:
        with system.open(place, "rb") as arrived:
            sound = hashlib.file_digest(arrived, "sha256").hexdigest() == entry.sha256
    finally:
        if not sound:  # a manifest that stayed would take the version
            system.rm_file(place)
    if not sound:
        raise PublishError(f"{target}: {source.name} reads otherwise than it was sent; upload again")


def _listed(folder: Path) -> tuple[str, str, dict[str, FileEntry]]:
    """Scenario, version and files of a map or dataset."""
    if is_dataset(folder):
        from gaitflow.publishing.dataset import read_manifest as read_dataset_manifest

        dataset = read_dataset_manifest(folder)
        return dataset.scenario, dataset.version, dataset.files
    manifest = read_manifest(folder)
    return manifest.name, str(manifest.version), dict(manifest.files)
