"""`gaitflow labels`: the best gait of each task of a published dataset."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from gaitflow.cli.errors import bad_input, print_json
from gaitflow.cli.options import json_option
from gaitflow.core.task import AXES

NEEDED = ("gait", "pattern", "cost", "margin", "runner_up", "status", "split", "label")
ADDED = ("cost_error", "resolved")  # of labels older than these, nothing is known


@click.command()
@click.argument("dataset", type=click.Path(exists=True, path_type=Path))
@json_option
def labels(dataset: Path, as_json: bool) -> None:
    """Print the labels of a published DATASET (a version's folder): the best gait of each task.

    With --json: a list of objects with the task's axes, gait, pattern, cost, margin and runner_up; cost_error is the
    relative error of both costs by a finer mesh, resolved whether the margin exceeds it.

    \b
    Example: gaitflow labels datasets/quickstart/1.0.0 --json
    """
    with bad_input():
        rows = read_labels(dataset)
    if as_json:
        return print_json(rows)
    for row in rows:
        task = "  ".join(f"{row[axis]:6.3f} {AXES[axis].unit}" for axis in row if axis in AXES)
        cost = row["status"] if row["cost"] is None else f"{row['gait']} {row['pattern']} cost {row['cost']:.6g}"
        click.echo(f"{task}  {cost}")


def read_labels(dataset: Path) -> list[dict[str, Any]]:
    """The labels of a published dataset, or of a labels file, as plain data; what does not exist is None.

    Raises ValueError that names the file when it cannot be read or holds no labels.
    """
    import pandas as pd

    from gaitflow.publishing.dataset import LABELS

    path = dataset / LABELS if dataset.is_dir() else dataset
    try:
        frame = pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: no readable labels ({error})") from None
    missing = [name for name in ("speed", "cycle_duration", *NEEDED, "ties") if name not in frame.columns]
    if missing:
        raise ValueError(f"{path}: these are no labels: column {missing[0]} is missing")
    axes = [name for name in frame.columns if name in AXES]
    unknown = dict.fromkeys(ADDED)
    kept = frame[[*axes, *NEEDED, *(name for name in ADDED if name in frame.columns), "ties"]]
    return [unknown | {str(k): _plain(v) for k, v in row.items()} for row in kept.to_dict("records")]


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return list(value) if hasattr(value, "tolist") else value
