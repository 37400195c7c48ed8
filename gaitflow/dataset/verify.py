"""Verifying a published dataset whole: digests, readability, and every stored motion by the independent check."""

from __future__ import annotations

from pathlib import Path

from gaitflow.core.check import FEASIBLE, worst
from gaitflow.dataset.read import FILE_NAME, load_solutions
from gaitflow.files import sha256_file
from gaitflow.publishing.dataset import CARD, GAIT_COSTS, LABELS, MANIFEST, read_manifest

NAMES = frozenset({FILE_NAME, LABELS, GAIT_COSTS, CARD})


def verify_dataset(folder: Path) -> list[str]:
    """Every fault of the dataset in `folder`, a version's folder; an empty list when it is sound."""
    try:
        manifest = read_manifest(folder)
    except ValueError as error:
        return [str(error)]
    found = {path.name for path in folder.iterdir()}
    faults = [f"{name}: does not belong to the dataset" for name in sorted(found - NAMES - {MANIFEST})]
    faults += [f"{name}: is missing" for name in sorted(NAMES - found)]
    for name in sorted(NAMES & found):
        if sha256_file(folder / name) != manifest.get("files", {}).get(name, {}).get("sha256"):
            faults.append(f"{name}: damaged: its bytes do not match the manifest")
    return faults or _motion_faults(folder)


def _motion_faults(folder: Path) -> list[str]:
    solutions = load_solutions(folder)
    scenario = solutions.record["scenario"]
    faults = []
    for row in solutions:
        if row.trajectory is None:
            continue
        violation = worst(scenario, row.trajectory, row.speed, row.cycle_duration, row.pattern)
        if violation > FEASIBLE:
            task = f"{row.speed:g} m/s, {row.cycle_duration:g} s, pattern {row.pattern}"
            faults.append(f"{FILE_NAME}: {task}: violates a constraint by {violation:.1e}, more than {FEASIBLE:g}")
    return faults
