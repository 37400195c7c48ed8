"""What is asked of published maps and datasets, wherever their runs are: reports, faults, the paper's statements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    from gaitflow.report.claims import Claim


def report_published(workspace: Workspace, path: Path, output: Path | None) -> list[Path]:
    """Draw the report of a published map or dataset: a version's folder, or the newest version in a folder of them.

    Into `output`, or `runs/<scenario>/report-<version>`. Raises ValueError when `path` is neither, ArtifactError.
    """
    from gaitflow.publishing.find import dataset_of_map, is_map, version_folder
    from gaitflow.report.published import write_dataset_report, write_map_report

    folder = version_folder(path)
    named = folder.resolve()
    target = output or workspace.root / "runs" / named.parent.name / f"report-{named.name}"
    if is_map(folder):
        return write_map_report(target, folder, dataset_of_map(folder, workspace.datasets))
    return write_dataset_report(target, folder)


def claims(workspace: Workspace) -> tuple[Claim, ...]:
    """The paper's statements, measured on the newest published grids of its scenarios and of the exact ones.

    Versions whose tasks were chosen (`tasks: {sampling: adaptive}`) are passed over: the statements count grid tasks.
    """
    from gaitflow.dataset import load_solutions
    from gaitflow.report.claims import SCENARIOS, check_claims
    from gaitflow.report.map_tasks import newest_grid
    from gaitflow.report.stored import scenario_of
    from gaitflow.report.winners import winners

    frames, motions = {}, {}
    for name in SCENARIOS:
        found = newest_grid(workspace.datasets / name)
        if found is not None:
            folder, frames[name] = found
            solutions = load_solutions(folder)
            on_grid = frames[name][frames[name]["split"] == "grid"]
            motions[name] = winners(on_grid, solutions, scenario_of(solutions).tasks.space)
    return check_claims(frames, motions)


def verify(path: Path) -> list[str]:
    """Every fault of a published map or dataset, of the newest version when `path` holds several.

    Raises ValueError when `path` is neither.
    """
    from gaitflow.publishing import verify as verify_map
    from gaitflow.publishing.find import is_dataset, version_folder
    from gaitflow.publishing.verify_dataset import verify_dataset

    folder = version_folder(path)
    found = verify_dataset(folder) if is_dataset(folder) else verify_map(folder)
    return [str(finding) for finding in found]
