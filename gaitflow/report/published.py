"""The report of a published map or dataset, from its files alone."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.dataset.read import load_solutions
from gaitflow.publishing.dataset_facts import LABELS
from gaitflow.report.certificate import SamplingRecord
from gaitflow.report.map_answers import map_answers
from gaitflow.report.report import write_report
from gaitflow.report.stored import scenario_of
from gaitflow.runtime import GaitMap
from gaitflow.runtime.artifact import load_artifact


def write_dataset_report(folder: Path, dataset: Path) -> list[Path]:
    """Draw the dataset of one version into `folder`; returns the files. Raises ValueError, WriteError."""
    solutions = load_solutions(dataset)
    scenario, labels = scenario_of(solutions), pd.read_parquet(dataset / LABELS)
    return write_report(folder, scenario, labels, list(solutions), [], None, None, solutions.record)


def write_map_report(folder: Path, model: Path, dataset: Path | None) -> list[Path]:
    """Draw the map of one version into `folder`, over the dataset that it was learnt from; returns the files.

    Without that dataset the tasks are those of the map's grid with its own answers, and there are no stored motions.
    Raises ArtifactError, ValueError, WriteError.
    """
    artifact = load_artifact(model)
    manifest, gait_map = artifact.manifest, GaitMap(artifact)
    gaits, learning = [gait.name for gait in gait_map.gaits], manifest.metrics
    scenario = Scenario.from_data(dict(manifest.scenario), f"{manifest.name} {manifest.version}")
    solutions = None if dataset is None else load_solutions(dataset)
    labels = map_answers(artifact) if dataset is None else pd.read_parquet(dataset / LABELS)
    return write_report(
        folder,
        scenario,
        labels,
        [] if solutions is None else list(solutions),
        gaits,
        lambda values: gait_map.select_many(**values).index,
        learning if "competitors" in learning else None,
        None if solutions is None else solutions.record,
        SamplingRecord(learning["certificate"], learning["sampling"]) if "sampling" in learning else None,
    )
