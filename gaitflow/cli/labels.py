"""`gaitflow labels`: the best gait of each task of a published dataset."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option
from gaitflow.core.task import AXES
from gaitflow.pipeline.workspace import Workspace

if TYPE_CHECKING:
    import pandas as pd

SHOWN = ("gait", "pattern", "cost", "margin", "runner_up", "status", "split", "label")
ADDED = ("cost_error", "resolved")  # of labels older than these, nothing is known


@click.command()
@click.argument("folder", type=PUBLISHED)
@json_option
@click.pass_obj
def labels(workspace: Workspace, folder: Path, as_json: bool) -> None:
    """Print the best gait of each task of a dataset or map.

    FOLDER is a published dataset or map (the folder of a version, or its parent) or a labels file. For a map the labels
    are those it was learnt from. If that dataset is not at hand, they are what the map predicts on its own grid. With
    --json: a list of objects with the task's axes, gait, pattern, cost, margin and runner_up. cost_error is the
    relative error of both costs by a finer mesh; resolved says whether the margin exceeds it.

    \b
    Example: gaitflow labels datasets/quickstart/1.0.0 --json
    """
    with bad_input(), refused_artifact():
        rows = plain_rows(_labels_of(folder, workspace.datasets))
    if as_json:
        return print_json(rows)
    for row in rows:
        task = "  ".join(f"{row[axis]:6.3f} {AXES[axis].unit}" for axis in row if axis in AXES)
        cost = row["status"] if row["cost"] is None else f"{row['gait']} {row['pattern']} cost {row['cost']:.6g}"
        click.echo(f"{task}  {cost}")


def _labels_of(path: Path, datasets: Path) -> pd.DataFrame:
    """The labels of what `path` is. Raises ValueError, ArtifactError when it is nothing of ours."""
    from gaitflow.dataset.labels_file import read_labels
    from gaitflow.publishing.find import dataset_of_map, is_map, version_folder
    from gaitflow.report.map_answers import map_answers
    from gaitflow.runtime.artifact import load_artifact

    if path.is_file():
        return read_labels(path).to_pandas()
    folder = version_folder(path)
    if not is_map(folder):
        return read_labels(folder).to_pandas()
    dataset = dataset_of_map(folder, datasets)
    return map_answers(load_artifact(folder)) if dataset is None else read_labels(dataset).to_pandas()


def plain_rows(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Labels as plain data; what does not exist is None."""
    axes = [name for name in frame.columns if name in AXES]
    unknown = dict.fromkeys(ADDED)
    kept = frame[[*axes, *SHOWN, *(name for name in ADDED if name in frame.columns), "ties"]]
    return [unknown | {str(k): _plain(v) for k, v in row.items()} for row in kept.to_dict("records")]


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return list(value) if hasattr(value, "tolist") else value
