"""The published map whose nodes a sampling begins with: its atlas, kept in the run for when that goes on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario
from gaitflow.files import atomic_write
from gaitflow.pipeline.workspace import Run
from gaitflow.problem import GaitProblem
from gaitflow.publishing.find import learnt_from, version_folder
from gaitflow.runtime.artifact import Artifact, load_artifact
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.runtime.atlas_reader import parse_atlas
from gaitflow.runtime.versions import Version, resolve


def keep_earlier(run: Run, scenario: Scenario, path: Path, dataset: Path) -> None:
    """Keep the atlas of the map at `path` in the run's folder, which begins from the searches of `dataset`.

    Raises ValueError unless the map is of the scenario's problem and axes, and learnt from that dataset or an earlier
    version of it: a certificate's fresh tasks are none of the dataset's, and must be none of the map's. Raises it as
    well where the sampling has begun without this map, ArtifactError for a map that is damaged, WriteError.
    """
    artifact = load_artifact(resolve(path))
    _check(artifact, scenario, version_folder(dataset))
    # Which gait a pattern is of, and which gaits there are, the new map decides.
    sheets = tuple(replace(sheet, gait=0) for sheet in artifact.atlas.sheets)
    content = atlas_bytes(replace(artifact.atlas, sheets=sheets))
    if run.earlier_atlas.exists() and run.earlier_atlas.read_bytes() == content:
        return
    if run.rounds.exists():
        raise ValueError(
            f"{scenario.name}: its sampling has begun already, and not with this map; leave --map away to go on with "
            f"it, or remove {run.rounds} and {run.earlier_atlas} to begin again"
        )
    atomic_write(run.earlier_atlas, content)


def earlier_atlas(run: Run, scenario: Scenario, problem: GaitProblem) -> Atlas | None:
    """The atlas that the sampling began with; None without one. Raises ArtifactError where it is damaged."""
    if not run.earlier_atlas.exists():
        return None
    content, axes = run.earlier_atlas.read_bytes(), scenario.tasks.space.ranged
    return parse_atlas(content, axes, 1, problem.layout, problem.ng, str(run.earlier_atlas))


def _check(artifact: Artifact, scenario: Scenario, dataset: Path) -> None:
    manifest = artifact.manifest
    name = f"{artifact.folder}: the map {manifest.name} {manifest.version}"
    try:
        own = Scenario.from_data(dict(manifest.scenario), manifest.name)
    except ConfigError as error:
        raise ValueError(f"{name} is of a scenario that this gaitflow does not know: {error}") from None
    if (own.problem_digest, own.tasks.space) != (scenario.problem_digest, scenario.tasks.space):
        raise ValueError(f"{name} is of another problem or other axes than {scenario.name}; give a map of these")
    learnt, version = str(manifest.dataset.get("name")), str(manifest.dataset.get("version"))
    if learnt != dataset.parent.name or Version.parse(version) > Version.parse(dataset.name):
        raise ValueError(
            f"{name} was learnt from the dataset {learnt_from(manifest)}; begin from that one, or a later version of "
            f"it, instead of {dataset}"
        )
