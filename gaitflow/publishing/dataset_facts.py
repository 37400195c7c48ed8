"""What there is to say of a published dataset, read from its files: the ground of its card and its metadata."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.core.layout import Layout
from gaitflow.core.legacy import modern_scenario
from gaitflow.dataset.read import FILE_NAME
from gaitflow.runtime.files import FileEntry, entry_of
from gaitflow.tables.columns import COLUMNS, Column
from gaitflow.tables.provenance import read_record
from gaitflow.tables.schema import BASE_STATES, array_shapes, task_columns

LABELS = "labels.parquet"
GAIT_COSTS = "gait_costs.parquet"
ROWS = {
    FILE_NAME: "one pattern at one task: what became of it, its cost, and for some rows the motion",
    LABELS: "one task: its best gait, the margin, how sure it is, and how good its motion is between the knots",
    GAIT_COSTS: "one gait at one task: its least cost",
}


@dataclass(frozen=True)
class Field:
    """A column of a table: `shape` of one value, () of a number or a text, (-1,) of a list of varying length."""

    name: str
    type: str
    shape: tuple[int, ...]
    column: Column


@dataclass(frozen=True)
class Table:
    """One file: its name without suffix is the table's, `row` says what a row is."""

    file: str
    row: str
    rows: int
    entry: FileEntry
    fields: tuple[Field, ...]

    @property
    def name(self) -> str:
        """What the table is called."""
        return self.file.removesuffix(".parquet")


@dataclass(frozen=True)
class DatasetFacts:
    """A dataset's version: `scenario` in today's form, `record` where it comes from, `created` UTC (ISO 8601).

    `motions` is how many rows of the solutions have a motion, `wins` how many tasks of a split a gait wins.
    """

    name: str
    version: str
    created: str
    scenario: Mapping[str, Any]
    record: Mapping[str, Any]
    tables: tuple[Table, ...]
    axes: tuple[str, ...]
    tasks: int
    solved: int
    motions: int
    wins: Mapping[tuple[str, str], int]


def dataset_facts(version: str, created: str, files: Mapping[str, bytes]) -> DatasetFacts:
    """The facts of the dataset whose tables are `files`, the content of each of ROWS. Raises ValueError."""
    with pq.ParquetFile(BytesIO(files[FILE_NAME])) as file:
        record = read_record(file.metadata.metadata, FILE_NAME)
        motions = file.read(columns=["base"])["base"]
    scenario = modern_scenario(record["scenario"])
    labels = pd.read_parquet(BytesIO(files[LABELS]))
    won = labels[labels["status"] == "solved"]
    *axes, _ = task_columns(labels.columns)
    return DatasetFacts(
        name=scenario["name"],
        version=version,
        created=created,
        scenario=scenario,
        record=record,
        tables=tuple(_table(name, row, files[name], scenario) for name, row in ROWS.items()),
        axes=tuple(axes),
        tasks=len(labels),
        solved=len(won),
        motions=len(motions) - motions.null_count,
        wins={(str(split), str(gait)): len(rows) for (split, gait), rows in won.groupby(["split", "gait"])},
    )


def _table(file: str, row: str, content: bytes, scenario: Mapping[str, Any]) -> Table:
    with pq.ParquetFile(BytesIO(content)) as opened:
        schema, rows = opened.schema_arrow, opened.metadata.num_rows
    shapes = array_shapes(Layout.of(scenario)) if file == FILE_NAME else {}
    fields = tuple(
        Field(field.name, _type(field.type), shapes.get(field.name, _shape(field.type)), _column(field.name, scenario))
        for field in schema
    )
    return Table(file, row, rows, entry_of(content), fields)


def _column(name: str, scenario: Mapping[str, Any]) -> Column:
    column = COLUMNS.get(name, Column(""))
    if name != "base":
        return column
    return Column(f"{column.meaning} ({', '.join(BASE_STATES[scenario['robot']['dimension']])})", column.unit)


def _type(kind: pa.DataType) -> str:
    value = kind.value_type if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind) else kind
    return "string" if pa.types.is_large_string(value) else str(value).replace("double", "float64")


def _shape(kind: pa.DataType) -> tuple[int, ...]:
    return (-1,) if pa.types.is_list(kind) else ()
