"""Publishing a version at an address that fsspec knows: whole, its manifest last, and never over another one."""

from __future__ import annotations

from pathlib import Path

from gaitflow.publishing.find import is_dataset
from gaitflow.publishing.versioned_folder import PublishError, VersionExists, file_faults
from gaitflow.runtime.files import MANIFEST, FileEntry
from gaitflow.runtime.manifest_file import read_manifest


def upload(folder: Path, address: str) -> str:
    """Copy the version in `folder` to `address`/<scenario>/<version> and return where that is.

    Its files are checked first. Who loads it meanwhile finds nothing, as the manifest comes last. Raises VersionExists
    when the version is there already, PublishError when a file is damaged or the address refuses, ValueError and
    ArtifactError when the manifest cannot be read.
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
        for file in (*sorted(entries), MANIFEST):
            system.pipe_file(f"{root}/{file}", (folder / file).read_bytes())
    except PublishError:
        raise
    except Exception as error:  # every file system raises errors of its own
        told = " ".join(str(error).split()) or type(error).__name__
        raise PublishError(f"{target}: cannot be written ({told[:300]})") from None
    return target


def _listed(folder: Path) -> tuple[str, str, dict[str, FileEntry]]:
    """Scenario, version and files of a map or dataset."""
    if is_dataset(folder):
        from gaitflow.publishing.dataset import read_manifest as read_dataset_manifest

        dataset = read_dataset_manifest(folder)
        return dataset.scenario, dataset.version, dataset.files
    manifest = read_manifest(folder)
    return manifest.name, str(manifest.version), dict(manifest.files)
