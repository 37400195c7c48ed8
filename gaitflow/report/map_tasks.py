"""Which tasks of a labels frame the map is made from, and what readers are told of how they were chosen."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from gaitflow.core.task import Split
from gaitflow.dataset.labels_file import read_labels
from gaitflow.runtime.versions import versions_in

SPLIT_WORDS: dict[Split, str] = {"grid": "grid", "sampled": "searched", "held_out": "held-out"}


def of_map(labels: pd.DataFrame) -> pd.Series[bool]:
    """Of each row whether the map is made from its task; the other tasks are held out and only judge the map."""
    return labels["split"] != "held_out"


def on_grid(labels: pd.DataFrame) -> bool:
    """Whether the map's tasks are those of a grid; otherwise they were chosen anywhere between its values."""
    return bool((labels["split"] == "grid").any())


def newest_grid(folder: Path) -> tuple[Path, pd.DataFrame] | None:
    """The newest version of a scenario's datasets whose tasks are a grid, and its labels; None where there is none."""
    for version in reversed(versions_in(folder)):
        labels = read_labels(folder / str(version)).to_pandas()
        if on_grid(labels):
            return folder / str(version), labels
    return None


def map_task_words(labels: pd.DataFrame) -> str:
    """What a task of the map is called: "grid task" or "searched task"."""
    return f"{SPLIT_WORDS['grid' if on_grid(labels) else 'sampled']} task"
