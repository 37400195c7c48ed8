"""Verifying a map whole: nothing missing, nothing foreign, no bit changed, every part fits, and it plans."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.atlas.patterns import map_symmetry
from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.core.errors import ArtifactError
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.names import gait_kind, gait_name
from gaitflow.publishing.versioned_folder import Finding, file_faults
from gaitflow.runtime import GaitMap
from gaitflow.runtime.artifact import load_artifact, load_atlas
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.files import ATLAS, CLASSIFIER, CONTENT, MANIFEST, PROBLEM_CHECK, WARM_STARTS, read_checked
from gaitflow.runtime.manifest import FORMAT, Manifest
from gaitflow.runtime.manifest_file import read_manifest
from gaitflow.runtime.problem import load_problem
from gaitflow.runtime.tensors import GaitTensors, parse_tensors
from gaitflow.runtime.versions import Version

START_OUTSIDE = 1e-6  # solvers leave bounds by less


def verify(path: Path, tasks: int = 4) -> list[Finding]:
    """Every fault of the map in `path`, a version's folder; an empty list when it is sound.

    Beside all files and what they hold, `tasks` grid tasks that the map calls feasible are planned; not with a map of
    formats 1 and 2, whose problem is code. Raises ImportError without CasADi, ArtifactError when `path` is no folder.
    """
    if not path.is_dir():
        raise ArtifactError(f"{path}: no such folder; give a version's folder such as models/<scenario>/1.0.0")
    findings = inspect(path)
    if findings:
        return findings
    manifest = read_manifest(path)
    if _is_version(path.name) and path.name != str(manifest.version):
        findings.append(Finding(MANIFEST, f"the folder is called {path.name}, the manifest says {manifest.version}"))
    return findings + (_planned(GaitMap.load(path), tasks) if manifest.format == FORMAT else [])


def inspect(folder: Path) -> list[Finding]:
    """The faults of the files in `folder` and of what they hold; nothing is planned."""
    try:
        manifest = read_manifest(folder)
    except ArtifactError as error:
        return [*_foreign(folder), Finding(MANIFEST, _without(folder, error))]
    findings = file_faults(folder, manifest.files)
    if findings:
        return findings
    if manifest.format < FORMAT:
        with _noted(findings, folder, MANIFEST):
            load_artifact(folder)
        return findings
    try:
        scenario = Scenario.from_data(dict(manifest.scenario), "scenario")
    except ConfigError as error:
        return [Finding(MANIFEST, str(error))]
    findings += _scenario_faults(manifest, scenario)
    with _noted(findings, folder, CLASSIFIER):
        _try_classifier(folder, manifest)
    with _noted(findings, folder, WARM_STARTS):
        content = read_checked(folder, WARM_STARTS, manifest.files[WARM_STARTS])
        tensors = parse_tensors(content, len(manifest.gaits), manifest.layout, str(folder / WARM_STARTS))
        findings += _tensor_faults(manifest, tensors)
        with _noted(findings, folder, ATLAS):
            findings += _atlas_faults(load_atlas(folder, manifest, tensors.rows), manifest, scenario)
        with _noted(findings, folder, PROBLEM_CHECK):
            load_problem(folder, manifest, tensors.rows)
    return findings


@contextmanager
def _noted(findings: list[Finding], folder: Path, name: str) -> Iterator[None]:
    try:
        yield
    except ArtifactError as error:
        findings.append(Finding(name, _without(folder, error)))


def _without(folder: Path, error: ArtifactError) -> str:
    """The error's text without the file's path in front, which the finding names itself."""
    text = str(error)
    for name in (MANIFEST, *CONTENT):
        text = text.removeprefix(f"{folder / name}: ")
    return text


def _foreign(folder: Path) -> list[Finding]:
    """Files that no map has; what of the others is missing only a manifest could tell."""
    names = {entry.name for entry in folder.iterdir()} - {MANIFEST, *CONTENT}
    return [Finding(name, "does not belong to the published files; remove it") for name in sorted(names)]


def _scenario_faults(manifest: Manifest, scenario: Scenario) -> list[Finding]:
    """The manifest's own parts against its scenario."""
    legs, symmetry = scenario.robot.leg_names, map_symmetry(scenario)
    mine: dict[str, Any] = {
        "scenario_digest": digest_of(dict(manifest.scenario)),
        "domain": {axis: values.values for axis, values in scenario.tasks.ranges.items()},
    }
    theirs: dict[str, Any] = {"scenario_digest": manifest.scenario_digest, "domain": dict(manifest.domain.axes)}
    for gait in manifest.gaits:
        canonical = gait_of(Pattern.from_text(gait.pattern), symmetry)
        names = gait_name(canonical, legs), f"{gait_kind(canonical, legs)} {canonical.text}"
        mine[f"gait of {gait.pattern}"] = (gait.name if gait.name in names else names[0], canonical.text)
        theirs[f"gait of {gait.pattern}"] = (gait.name, gait.key)
    return [
        Finding(MANIFEST, f"{name} is {theirs[name]}, but the scenario makes it {mine[name]}")
        for name in mine
        if mine[name] != theirs[name]
    ]


def _try_classifier(folder: Path, manifest: Manifest) -> None:
    """Ask for every task of the grid. Raises ArtifactError where the answer is none."""
    content = read_checked(folder, CLASSIFIER, manifest.files[CLASSIFIER])
    axes = manifest.domain.axes
    classifier = Classifier(content, len(axes), len(manifest.gaits), str(folder / CLASSIFIER))
    tasks = np.stack([values.ravel() for values in np.meshgrid(*axes.values())], axis=1)
    classifier(tasks.astype(np.float32))


def _tensor_faults(manifest: Manifest, tensors: GaitTensors) -> list[Finding]:
    outside = np.maximum(tensors.lower_bounds - tensors.primal, tensors.primal - tensors.upper_bounds).max(axis=1)
    return [
        Finding(WARM_STARTS, f"the start of {gait.name} lies outside its bounds by {excess:.1e}")
        for gait, excess in zip(manifest.gaits, outside, strict=True)
        if excess > START_OUTSIDE
    ]


def _atlas_faults(atlas: Atlas, manifest: Manifest, scenario: Scenario) -> list[Finding]:
    """Nodes outside the map's domain, and sheets whose pattern is none of their gait's."""
    domain, symmetry, findings = manifest.domain, map_symmetry(scenario), []
    for sheet in atlas.sheets:
        gait = manifest.gaits[sheet.gait]
        if gait_of(Pattern.from_text(sheet.pattern), symmetry).text != gait.key:
            findings.append(Finding(ATLAS, f"the pattern {sheet.pattern} of a sheet is not the gait {gait.name}"))
        inside = domain.contains_many(dict(zip(domain.axes, sheet.tasks.T, strict=True)))
        if not inside.all():
            place = dict(zip(domain.axes, sheet.tasks[~inside][0].tolist(), strict=True))
            told = scenario.tasks.space.task(place).text(domain.axes)
            findings.append(Finding(ATLAS, f"{gait.name} has a node at {told}, outside the map's domain"))
    return findings


def _planned(gait_map: GaitMap, tasks: int) -> list[Finding]:
    """Plans for some of the feasible grid tasks, evenly spread."""
    domain = gait_map.manifest.domain
    grid = [
        place
        for place, feasible in zip(product(*domain.axes.values()), domain.feasible.ravel(), strict=True)
        if feasible
    ]
    findings = []
    for index in np.unique(np.linspace(0, len(grid) - 1, min(tasks, len(grid))).round().astype(int)):
        task = dict(zip(domain.axes, grid[index], strict=True))
        plan = gait_map.plan(**task)
        if not plan.feasible:
            tried = "; ".join(f"{gait} {outcome}" for gait, outcome in plan.tried)
            asked = gait_map.manifest.space.task(task).text(domain.axes)
            findings.append(Finding(ATLAS, f"no feasible plan for {asked}: {tried}"))
    return findings


def _is_version(name: str) -> bool:
    try:
        Version.parse(name)
    except ValueError:
        return False
    return True
