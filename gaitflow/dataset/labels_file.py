"""The public reader of a dataset's labels: the best gait of each task."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from gaitflow.config.axes import MAX_GRID
from gaitflow.core.task import AXES, SPLITS, span
from gaitflow.core.task_space import MAIN_AXES
from gaitflow.dataset.legacy import modern_names
from gaitflow.tables.untrusted import file_in, opened, read_table

FILE_NAME = "labels.parquet"
MAX_ROWS = MAX_GRID + 100_000  # of a scenario's tasks: its grid and those held out
MAX_BYTES = 1 << 29  # of all columns when unpacked

_TEXTS = ("gait", "pattern", "runner_up", "status", "split", "label")
_NUMBERS = ("cost", "margin")
_ADDED = {"cost_error": pa.types.is_float64, "resolved": pa.types.is_boolean}  # labels may be older than these
_STATUSES = ("solved", "infeasible", "failed")


def read_labels(path: Path) -> pa.Table:
    """The labels in a Parquet file, or in the folder of one version of a dataset.

    Columns as docs/data-format.md describes them, gaits by their names of today, without nulls but for numbers that do
    not exist; a file may have more columns than these. Raises FileNotFoundError, and ValueError of one line that names
    the file and what is wrong.
    """
    file_path = file_in(path, FILE_NAME)
    with opened(file_path, MAX_ROWS) as file:
        if fault := _schema_fault(file.schema_arrow):
            raise ValueError(f"{file_path}: these are no labels: {fault}")
        table = read_table(file, file_path, MAX_BYTES).replace_schema_metadata(None)
        if fault := _value_fault(table):
            raise ValueError(f"{file_path}: these are no labels: {fault}")
    return modern_names(table)


def _schema_fault(schema: pa.Schema) -> str | None:
    axes = [name for name in schema.names if name in AXES]
    kinds: dict[str, Callable[[pa.DataType], bool]] = {
        **dict.fromkeys((*MAIN_AXES, *axes, *_NUMBERS), pa.types.is_float64),
        **dict.fromkeys(_TEXTS, _is_text),
        "ties": lambda kind: pa.types.is_list(kind) and _is_text(kind.value_type),
        **{name: is_kind for name, is_kind in _ADDED.items() if name in schema.names},
    }
    for name, is_kind in kinds.items():
        if name not in schema.names:
            return f"column {name} is missing"
        if not is_kind(schema.field(name).type):
            return f"column {name} is {str(schema.field(name).type)[:80]}"
    return None


def _value_fault(table: pa.Table) -> str | None:
    axes = [name for name in table.column_names if name in AXES]
    present = (*axes, *_TEXTS, "ties", *(["resolved"] if "resolved" in table.column_names else []))
    for name in present:
        if table[name].null_count or (name == "ties" and pc.list_flatten(table[name]).null_count):
            return f"column {name} has rows without a value"
    for axis in axes:
        values = table[axis].to_numpy()
        if not np.isfinite(values).all() or not all(map(AXES[axis].admits, _ends(values))):
            return f"column {axis} has values beyond {span(axis)}"
    for name, allowed in (("split", SPLITS), ("status", _STATUSES)):
        odd = set(pc.unique(table[name]).to_pylist()) - set(allowed)
        if odd:
            return f"column {name} has the value {min(odd)[:80]!r}; allowed: {', '.join(allowed)}"
    return None


def _ends(values: np.ndarray) -> tuple[float, ...]:
    return (float(values.min()), float(values.max())) if len(values) else ()


def _is_text(kind: pa.DataType) -> bool:
    return pa.types.is_string(kind) or pa.types.is_large_string(kind)
