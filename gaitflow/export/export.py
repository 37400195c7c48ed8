"""Exporting a map: from its folder to a folder of C, C++ and data."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np

from gaitflow.export.classifier_data import read_classifier
from gaitflow.export.folder import refuse_foreign, write_folder
from gaitflow.export.functions import FILES, c_files
from gaitflow.export.map_file import map_bytes
from gaitflow.runtime.artifact import load_artifact
from gaitflow.runtime.files import CLASSIFIER, LIMITS, MANIFEST, read_checked, read_limited
from gaitflow.runtime.problem import load_problem
from gaitflow.runtime.versions import resolve

MAP = "map.bin"
READER = (
    "gait_map.hpp", "atlas.hpp", "condensed.hpp", "trajectory.hpp", "map_file.hpp", "map_data.hpp", "function.hpp",
    "cursor.hpp", "classifier.hpp", "perceptron.hpp", "forest.hpp", "support_vectors.hpp", "neighbours.hpp",
    "scaler.hpp",
)  # fmt: skip
PLANNER = (
    "planner.hpp", "refine.hpp", "starts.hpp", "interior_point.hpp", "point.hpp", "kkt.hpp", "paths.hpp", "ldlt.hpp",
    "dense.hpp", "fronts.hpp", "ordering.hpp", "short_rows.hpp", "program.hpp",
)  # fmt: skip
CMAKE = "gaitflow_map-config.cmake"
LIBRARY = ("library.cpp", "CMakeLists.txt")
SOURCES = ("map.h", *(f"{name}{suffix}" for name in FILES for suffix in (".c", ".h")))
COPIED = (*READER, *PLANNER, CMAKE, *LIBRARY)
CONTENT = (MAP, *SOURCES, *COPIED)


@dataclass(frozen=True)
class Exported:
    """What was written from where: sizes of the files [bytes] by name."""

    model: Path
    folder: Path
    sizes: dict[str, int]


def export_c(model: Path, folder: Path, trust_code: bool = False) -> Exported:
    """Write the map `models/<scenario>/<version>`, or the newest version in `models/<scenario>`, to `folder`.

    An earlier export there is replaced. `trust_code` allows to run the code that maps of formats 1 and 2 hold as their
    problem. Raises ArtifactError for a damaged map, CannotExport for a classifier that `gaitflow train` does not
    make and a folder that holds anything else, WriteError when the disk refuses; then nothing is written.
    """
    refuse_foreign(folder, CONTENT)
    source = resolve(model)
    artifact = load_artifact(source)
    manifest = artifact.manifest
    onnx = read_checked(source, CLASSIFIER, manifest.files[CLASSIFIER])
    classifier = read_classifier(onnx, manifest.classifier_kind, str(source / CLASSIFIER))
    digest = hashlib.sha256(read_limited(source / MANIFEST, LIMITS[MANIFEST])).digest()
    written = {MAP: map_bytes(artifact, digest, classifier)}
    problem = load_problem(source, manifest, artifact.tensors.rows, trust_code)
    default_feet = np.array([leg["default_foot"] for leg in manifest.scenario["robot"]["legs"]])
    written |= c_files(problem, manifest.layout, default_feet, manifest.name)
    written |= {name: files("gaitflow.export").joinpath("cpp", name).read_bytes() for name in COPIED}
    write_folder(folder, written)
    return Exported(source, folder, {name: len(data) for name, data in written.items()})
