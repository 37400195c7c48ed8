"""A published dataset as a folder that others can find, cite, load and make again."""

from __future__ import annotations

from pathlib import Path

from gaitflow.files import atomic_write
from gaitflow.publishing import croissant, ro_crate
from gaitflow.publishing.dataset import read_manifest
from gaitflow.publishing.dataset_card import dataset_card
from gaitflow.publishing.dataset_facts import ROWS, dataset_facts
from gaitflow.publishing.remake import remake_files
from gaitflow.runtime.files import CARD, read_checked_as

_DESCRIBED = {CARD: "the card: every column, how to load it, how it was made", croissant.FILE: "Croissant metadata"}


def describe_dataset(folder: Path, output: Path) -> list[Path]:
    """Write the tables of the dataset in `folder`, a version's, into `output` with all that describes them.

    Beside the tables: README.md (the card), croissant.json, ro-crate-metadata.json, and a workflow with its scenario
    and robot that makes the dataset again. Returns the files. Every table is checked against the manifest. Raises
    ValueError, ArtifactError when the dataset is damaged or `output` lies within it, WriteError.
    """
    if output.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{output}: lies in {folder}, which was published and never changes; choose another folder")
    manifest = read_manifest(folder)
    tables = {name: read_checked_as(folder / name, manifest.files[name]) for name in ROWS}
    facts = dataset_facts(manifest.version, manifest.created, tables)
    files = tables | {name: text.encode() for name, text in remake_files(facts.scenario).items()}
    files[CARD] = dataset_card(facts).encode()
    files[croissant.FILE] = croissant.croissant(facts).encode()
    files[ro_crate.FILE] = ro_crate.ro_crate(facts, _DESCRIBED).encode()
    for name, content in files.items():
        atomic_write(output / name, content)
    return [output / name for name in files]
