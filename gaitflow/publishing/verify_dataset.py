"""Verifying a published dataset whole: digests, readability, and every stored motion by the independent check."""

from __future__ import annotations

from pathlib import Path

from gaitflow.core.check import FEASIBLE, cost, worst
from gaitflow.core.joints import Joints
from gaitflow.dataset.read import FILE_NAME, load_solutions
from gaitflow.publishing.dataset import FILES, read_manifest
from gaitflow.publishing.versioned_folder import Finding, file_faults
from gaitflow.runtime.files import MANIFEST

COST_DIFFERS = 0.01  # relative: more than the quadrature of a cost may be off by
ENERGY_DIFFERS = 0.1  # the same of energy, whose standing legs count at the knots alone


def verify_dataset(folder: Path) -> list[Finding]:
    """Every fault of the dataset in `folder`, a version's folder; an empty list when it is sound."""
    try:
        manifest = read_manifest(folder)
    except ValueError as error:
        return [Finding(MANIFEST, str(error))]
    unlisted = [Finding(name, "is missing from the manifest") for name in sorted(set(FILES) - set(manifest.files))]
    faults = unlisted + file_faults(folder, {name: manifest.files[name] for name in FILES if name in manifest.files})
    if faults:
        return faults
    try:
        return _motion_faults(folder)
    except ValueError as error:
        return [Finding(FILE_NAME, str(error))]


def _motion_faults(folder: Path) -> list[Finding]:
    solutions = load_solutions(folder)
    scenario = solutions.record["scenario"]
    differs = COST_DIFFERS if Joints.of(scenario) is None else ENERGY_DIFFERS
    faults = []
    for row in solutions:
        if row.trajectory is None:
            continue
        where = f"{row.task.text()}, pattern {row.pattern}"
        violation = worst(scenario, row.trajectory, row.task, row.pattern)
        if not violation <= FEASIBLE:  # NaN is no verdict
            told = f"{where}: violates a constraint by {violation:.1e}, more than {FEASIBLE:g}"
            faults.append(Finding(FILE_NAME, told))
            continue
        integrated = cost(scenario, row.trajectory, row.task, row.pattern)
        if not abs(row.cost - integrated) <= differs * abs(integrated):
            told = f"{where}: the cost is {row.cost:.6g}, the motion's is {integrated:.6g}"
            faults.append(Finding(FILE_NAME, told))
    return faults
