"""The files of a map that answer questions: read, checked against the manifest, and put together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.atlas_reader import parse_atlas
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.files import ATLAS, CLASSIFIER, WARM_STARTS, read_checked
from gaitflow.runtime.legacy_atlas import parse_gridded_atlas
from gaitflow.runtime.manifest import FORMAT, Manifest
from gaitflow.runtime.manifest_file import read_manifest
from gaitflow.runtime.tensors import GaitTensors, parse_tensors


@dataclass(frozen=True, eq=False)
class Artifact:
    """A published map in `folder`; of format 1 the atlas is empty."""

    folder: Path
    manifest: Manifest
    classifier: Classifier
    tensors: GaitTensors
    atlas: Atlas

    def pattern(self, gait: int, sheet: int | None) -> str:
        """The pattern of a gait by a sheet of the atlas, or of its region's mean when that is None."""
        return self.manifest.gaits[gait].pattern if sheet is None else self.atlas.sheets[sheet].pattern


def load_artifact(folder: Path) -> Artifact:
    """The artifact in the folder of one version. Raises ArtifactError that names the file and what is wrong with it."""
    manifest = read_manifest(folder)
    gaits, axes, files = len(manifest.gaits), manifest.space.ranged, manifest.files
    content = read_checked(folder, CLASSIFIER, files[CLASSIFIER])
    classifier = Classifier(content, len(axes), gaits, str(folder / CLASSIFIER))
    content = read_checked(folder, WARM_STARTS, files[WARM_STARTS])
    where = str(folder / WARM_STARTS)
    tensors = parse_tensors(content, gaits, manifest.layout, where, scaled=manifest.format < FORMAT)
    return Artifact(folder, manifest, classifier, tensors, load_atlas(folder, manifest, tensors.rows))


def load_atlas(folder: Path, manifest: Manifest, rows: int) -> Atlas:
    """The atlas of the map in `folder`, an empty one for a map of before there were any; `rows` of its problem.

    Raises ArtifactError when it is damaged or does not fit the manifest.
    """
    if ATLAS not in manifest.files:
        return Atlas.empty(manifest.space.ranged)
    content, where = read_checked(folder, ATLAS, manifest.files[ATLAS]), str(folder / ATLAS)
    if manifest.format < FORMAT:
        return parse_gridded_atlas(content, len(manifest.gaits), manifest.layout, rows, where)
    return parse_atlas(content, manifest.space.ranged, len(manifest.gaits), manifest.layout, rows, where)
