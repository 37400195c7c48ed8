"""`gaitflow labels`: the best gait of each task of a published dataset."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from gaitflow.cli.errors import bad_input, print_json
from gaitflow.cli.options import json_option
from gaitflow.core.task import AXES

SHOWN = ("gait", "pattern", "cost", "margin", "runner_up", "status", "split", "label")
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
        rows = _rows(dataset)
    if as_json:
        return print_json(rows)
    for row in rows:
        task = "  ".join(f"{row[axis]:6.3f} {AXES[axis].unit}" for axis in row if axis in AXES)
        cost = row["status"] if row["cost"] is None else f"{row['gait']} {row['pattern']} cost {row['cost']:.6g}"
        click.echo(f"{task}  {cost}")


def _rows(dataset: Path) -> list[dict[str, Any]]:
    """The labels as plain data; what does not exist is None."""
    from gaitflow.dataset.labels_file import read_labels

    table = read_labels(dataset)
    axes = [name for name in table.column_names if name in AXES]
    kept = table.select([*axes, *SHOWN, *(name for name in ADDED if name in table.column_names), "ties"])
    unknown = dict.fromkeys(ADDED)
    return [unknown | {key: _plain(value) for key, value in row.items()} for row in kept.to_pylist()]


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
