"""Which published folder is meant: that of one version, the newest of several, or the dataset behind a map."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.dataset.read import FILE_NAME
from gaitflow.runtime.files import CLASSIFIER, MANIFEST
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.manifest_file import read_manifest
from gaitflow.runtime.versions import versions_in
from gaitflow.tables.provenance import read_record


def version_folder(path: Path) -> Path:
    """The folder of one version: `path` itself when it holds files of ours, else the newest version in it.

    Raises ValueError when there is no such folder, or neither files nor versions in it.
    """
    if not path.is_dir():
        raise ValueError(f"{path}: no such folder; give that of a map or dataset, such as models/<scenario>")
    if is_map(path) or is_dataset(path) or (path / MANIFEST).exists():
        return path
    versions = versions_in(path)
    if not versions:
        raise ValueError(f"{path}: holds neither a map nor a dataset, nor versions of one such as 1.0.0")
    return path / str(versions[-1])


def is_map(folder: Path) -> bool:
    """Whether this is the folder of a map's version."""
    return (folder / CLASSIFIER).exists()


def is_dataset(folder: Path) -> bool:
    """Whether this is the folder of a dataset's version, or of a run."""
    return (folder / FILE_NAME).exists()


def dataset_folder(path: Path, datasets: Path) -> Path:
    """The folder of a dataset's version: what `version_folder` finds, or when that is a map, what it was learnt from.

    A map's dataset is looked for in `datasets`, and in a `datasets` beside the `models` that the map lies in. Raises
    ValueError when there is none, ArtifactError when the map's manifest cannot be read.
    """
    folder = version_folder(path)
    if not is_map(folder):
        return folder
    found = dataset_of_map(folder, datasets)
    if found is None:
        named, places = learnt_from(read_manifest(folder)), " or ".join(map(str, _places(folder, datasets)))
        raise ValueError(f"{folder}: was learnt from the dataset {named}, which is not in {places}; copy it there")
    return found


def dataset_of_map(folder: Path, datasets: Path) -> Path | None:
    """The dataset that the map in `folder`, a version's, was learnt from, found as `dataset_folder` does; None if not.

    Raises ArtifactError when the map's manifest cannot be read.
    """
    manifest = read_manifest(folder)
    name, version = str(manifest.dataset.get("name", manifest.name)), str(manifest.dataset["version"])
    # A manifest is another's word: no name of its leads out of these folders.
    if not all(Path(part).name == part for part in (name, version)):
        return None
    scenarios = [place / name for place in _places(folder, datasets)]
    if "name" in manifest.dataset:
        found = [scenario / version for scenario in scenarios]
    else:
        versions = [scenario / str(each) for scenario in scenarios for each in versions_in(scenario)]
        found = [each for each in versions if _units_digest(each) == manifest.dataset["digest"]]
    return next((each for each in found if is_dataset(each)), None)


def learnt_from(manifest: Manifest) -> str:
    """What a map was learnt from, for a reader. Maps of formats 1 and 2 only have the digest of its units of work."""
    dataset = manifest.dataset
    if "name" in dataset:
        return f"{dataset['name']} {dataset['version']}"
    return f"{manifest.name} whose units of work have the digest {dataset['digest']}"


def _places(folder: Path, datasets: Path) -> list[Path]:
    beside = [place / "datasets" for place in folder.absolute().parents[2:3]]
    return list(dict.fromkeys((datasets, *beside)))


def _units_digest(folder: Path) -> str | None:
    file = folder / FILE_NAME
    try:
        return str(read_record(pq.read_metadata(file).metadata, str(file))["units_digest"])
    except (OSError, ValueError, KeyError, pa.ArrowException):
        return None
