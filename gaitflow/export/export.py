"""A map's folder in, a folder of C, C++ and data out."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from gaitflow.export.folder import refuse_foreign, write_folder
from gaitflow.export.functions import FILES, c_files
from gaitflow.export.map_file import map_bytes
from gaitflow.export.network import read_network
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.files import CLASSIFIER, LIMITS, MANIFEST, WARM_STARTS, read_checked, read_limited
from gaitflow.runtime.gait_map import load_atlas
from gaitflow.runtime.manifest import parse_manifest
from gaitflow.runtime.problem import load_problem
from gaitflow.runtime.tensors import parse_tensors
from gaitflow.runtime.versions import resolve

MAP = "map.bin"
READER = ("gait_map.hpp", "trajectory.hpp", "map_file.hpp", "map_data.hpp", "function.hpp")
SOURCES = ("map.h", *(f"{name}{suffix}" for name in FILES for suffix in (".c", ".h")))
CONTENT = (MAP, *SOURCES, *READER)


@dataclass(frozen=True)
class Exported:
    """What was written from where: sizes of the files [bytes] by name."""

    model: Path
    folder: Path
    sizes: dict[str, int]


def export_c(model: Path, folder: Path) -> Exported:
    """Write the map `models/<scenario>/<version>`, or the newest version in `models/<scenario>`, to `folder`.

    An earlier export there is replaced. Raises ArtifactError for a damaged map, CannotExport for a classifier that is
    no perceptron and a folder that holds anything else, WriteError when the disk refuses; then nothing is written.
    """
    refuse_foreign(folder, CONTENT)
    source = resolve(model)
    content = read_limited(source / MANIFEST, LIMITS[MANIFEST])
    manifest = parse_manifest(content, str(source / MANIFEST))
    onnx, where = read_checked(source, CLASSIFIER, manifest.files[CLASSIFIER]), str(source / CLASSIFIER)
    Classifier(onnx, len(manifest.gaits), where)
    network = read_network(onnx, manifest.classifier_kind, where)
    starts = read_checked(source, WARM_STARTS, manifest.files[WARM_STARTS])
    tensors = parse_tensors(starts, len(manifest.gaits), manifest.layout, str(source / WARM_STARTS))
    digest = hashlib.sha256(content).digest()
    written = {MAP: map_bytes(manifest, digest, network, tensors, load_atlas(source, manifest))}
    written |= c_files(load_problem(source, manifest), manifest.name)
    written |= {name: files("gaitflow.export").joinpath("cpp", name).read_bytes() for name in READER}
    write_folder(folder, written)
    return Exported(source, folder, {name: len(data) for name, data in written.items()})
