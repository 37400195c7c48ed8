"""Verifying an artifact whole: nothing missing, nothing foreign, no bit changed, every part fits, and it plans."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.core.errors import ArtifactError
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.names import gait_name
from gaitflow.core.layout import layout_of
from gaitflow.runtime import GaitMap
from gaitflow.runtime.classifier import Classifier
from gaitflow.runtime.files import ATLAS, CLASSIFIER, MANIFEST, PROBLEM, WARM_STARTS, read_checked
from gaitflow.runtime.gait_map import load_atlas
from gaitflow.runtime.manifest import CONTENT, Manifest, read_manifest
from gaitflow.runtime.problem import load_problem
from gaitflow.runtime.tensors import GaitTensors, parse_tensors
from gaitflow.runtime.versions import Version

PROBABILITY_SUM = 1e-4  # float32 probabilities of some hundred gaits add up to 1 within this
START_OUTSIDE = 1e-6  # solvers leave bounds by less


@dataclass(frozen=True)
class Finding:
    """One fault: the file it is in, and what is wrong."""

    file: str
    fault: str

    def __str__(self) -> str:
        return f"{self.file}: {self.fault}"


def verify(path: Path, tasks: int = 4) -> list[Finding]:
    """Every fault of the artifact in `path`, a version's folder; an empty list when it is sound.

    Beside all files and what they hold, `tasks` grid tasks that the map calls feasible are planned. Raises ImportError
    without CasADi, ArtifactError when `path` is no folder.
    """
    if not path.is_dir():
        raise ArtifactError(f"{path}: no such folder; give a version's folder such as models/<scenario>/1.0.0")
    findings = inspect(path)
    if findings:
        return findings
    manifest = read_manifest(path)
    if _is_version(path.name) and path.name != str(manifest.version):
        findings.append(Finding(MANIFEST, f"the folder is called {path.name}, the manifest says {manifest.version}"))
    return findings + _planned(GaitMap.load(path), tasks)


def inspect(folder: Path) -> list[Finding]:
    """The faults of the files in `folder` and of what they hold; nothing is planned."""
    try:
        manifest = read_manifest(folder)
    except ArtifactError as error:
        return [*_foreign(folder, CONTENT), Finding(MANIFEST, _without(folder, error))]
    findings = _foreign(folder, manifest.files)
    for name in manifest.files:
        with _noted(findings, folder, name):
            read_checked(folder, name, manifest.files[name])
    if findings:
        return findings
    findings += _scenario_faults(manifest)
    with _noted(findings, folder, CLASSIFIER):
        findings += _classifier_faults(folder, manifest)
    with _noted(findings, folder, WARM_STARTS):
        content = read_checked(folder, WARM_STARTS, manifest.files[WARM_STARTS])
        tensors = parse_tensors(content, len(manifest.gaits), manifest.layout, str(folder / WARM_STARTS))
        findings += _tensor_faults(manifest, tensors)
        with _noted(findings, folder, ATLAS):
            findings += _atlas_faults(folder, manifest)
        with _noted(findings, folder, PROBLEM):
            findings += _problem_faults(folder, manifest, tensors)
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


def _foreign(folder: Path, content: Iterable[str]) -> list[Finding]:
    names = {entry.name for entry in folder.iterdir()}
    return [
        Finding(name, "does not belong to the artifact; remove it") for name in sorted(names - {MANIFEST, *content})
    ]


def _scenario_faults(manifest: Manifest) -> list[Finding]:
    """The manifest's own parts against its scenario."""
    try:
        scenario = Scenario.from_data(dict(manifest.scenario), "scenario")
    except ConfigError as error:
        return [Finding(MANIFEST, str(error))]
    robot, problem, layout = scenario.robot, layout_of(scenario), manifest.layout
    mine: dict[str, Any] = {
        "scenario_digest": digest_of(dict(manifest.scenario)),
        "domain": (scenario.tasks.speed.values, scenario.tasks.cycle_duration.values),
        "layout": (problem.phases, problem.knots_per_phase, robot.leg_names, problem.dimension, problem.nb, problem.nw),
    }
    theirs: dict[str, Any] = {
        "scenario_digest": manifest.scenario_digest,
        "domain": (manifest.domain.speeds, manifest.domain.cycle_durations),
        "layout": (layout.phases, layout.knots_per_phase, layout.legs, layout.dimension, layout.base, layout.variables),
    }
    for gait in manifest.gaits:
        canonical = gait_of(Pattern.from_text(gait.pattern), robot.mirror_permutation)
        mine[f"gait of {gait.pattern}"] = (gait_name(canonical, robot.leg_names), canonical.text)
        theirs[f"gait of {gait.pattern}"] = (gait.name, gait.key)
    return [
        Finding(MANIFEST, f"{name} is {theirs[name]}, but the scenario makes it {mine[name]}")
        for name in mine
        if mine[name] != theirs[name]
    ]


def _classifier_faults(folder: Path, manifest: Manifest) -> list[Finding]:
    content = read_checked(folder, CLASSIFIER, manifest.files[CLASSIFIER])
    classifier = Classifier(content, len(manifest.gaits), str(folder / CLASSIFIER))
    v, t = np.meshgrid(manifest.domain.speeds, manifest.domain.cycle_durations)
    probabilities = classifier(np.column_stack([v.ravel(), t.ravel()]).astype(np.float32)).astype(float)
    if (probabilities >= 0).all() and np.abs(probabilities.sum(axis=1) - 1).max() <= PROBABILITY_SUM:
        return []
    return [Finding(CLASSIFIER, "its probabilities are not at least 0 with sum 1 at every task of the grid")]


def _tensor_faults(manifest: Manifest, tensors: GaitTensors) -> list[Finding]:
    outside = np.maximum(tensors.lower_bounds - tensors.primal, tensors.primal - tensors.upper_bounds).max(axis=1)
    findings = [
        Finding(WARM_STARTS, f"the start of {gait.name} lies outside its bounds by {excess:.1e}")
        for gait, excess in zip(manifest.gaits, outside, strict=True)
        if excess > START_OUTSIDE
    ]
    if (tensors.scale[slice(*manifest.layout.duration_slice)] != 1).any():
        findings.append(Finding(WARM_STARTS, "the scale of the durations must be 1: they are fractions of the cycle"))
    return findings


def _atlas_faults(folder: Path, manifest: Manifest) -> list[Finding]:
    """Nodes outside the map's domain, and sheets whose pattern is none of their gait's."""
    atlas, domain, findings = load_atlas(folder, manifest), manifest.domain, []
    scenario = Scenario.from_data(dict(manifest.scenario), "scenario")
    for sheet in atlas.sheets:
        gait = manifest.gaits[sheet.gait]
        if gait_of(Pattern.from_text(sheet.pattern), scenario.robot.mirror_permutation).text != gait.key:
            findings.append(Finding(ATLAS, f"the pattern {sheet.pattern} of a sheet is not the gait {gait.name}"))
        tasks = [(atlas.speeds[i], atlas.cycle_durations[j]) for i, j in sheet.places.tolist()]
        outside = [task for task in tasks if not domain.contains(*task)]
        if outside:
            v, t = outside[0]
            findings.append(Finding(ATLAS, f"{gait.name} has a node at ({v:g} m/s, {t:g} s), outside the map's domain"))
    return findings


def _problem_faults(folder: Path, manifest: Manifest, tensors: GaitTensors) -> list[Finding]:
    problem = load_problem(folder, manifest)
    task = [manifest.domain.speeds[0], manifest.domain.cycle_durations[0]]
    return [
        Finding(PROBLEM, f"cost or rows at the start of {gait.name} are not finite")
        for gait, primal in zip(manifest.gaits, tensors.primal, strict=True)
        if not all(np.isfinite(np.asarray(value)).all() for value in problem(primal, task))
    ]


def _planned(gait_map: GaitMap, tasks: int) -> list[Finding]:
    """Plans for some of the feasible grid tasks, evenly spread."""
    domain = gait_map.manifest.domain
    grid = [
        (v, t) for v, row in zip(domain.speeds, domain.feasible, strict=True)
        for t, feasible in zip(domain.cycle_durations, row, strict=True) if feasible
    ]  # fmt: skip
    findings = []
    for index in np.unique(np.linspace(0, len(grid) - 1, min(tasks, len(grid))).round().astype(int)):
        v, t = grid[index]
        plan = gait_map.plan(v, t)
        if not plan.feasible:
            tried = "; ".join(f"{gait} {outcome}" for gait, outcome in plan.tried)
            findings.append(Finding(PROBLEM, f"no feasible plan for task ({v:g} m/s, {t:g} s): {tried}"))
    return findings


def _is_version(name: str) -> bool:
    try:
        Version.parse(name)
    except ValueError:
        return False
    return True
