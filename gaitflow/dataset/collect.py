"""Merging the parts of a run into one dataset file whose rows do not depend on who solved what when."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from gaitflow.config.scenario import Scenario
from gaitflow.dataset.provenance import dataset_record, read_record
from gaitflow.dataset.read import FILE_NAME
from gaitflow.dataset.schema import HEAVY, MULTIPLIERS, scalar_columns, solution_schema, task_columns
from gaitflow.files import new_file
from gaitflow.store.parts import DamagedPart, UnitStore
from gaitflow.store.seal import check_seal, write_sealed
from gaitflow.store.units import Unit, plan_units

PUBLISHED_LEVEL = 15  # of zstd: what is published is written once
ROWS_PER_GROUP = 2000  # rows held in memory at a time
OPEN_PARTS = 8
TABLES_AT_ONCE = 1000
MAKERS = ("made_by", "solver_options")  # what a dataset's record keeps of those of its parts


Mask = NDArray[np.bool_]


class NotComplete(ValueError):
    """Units are missing or damaged, so that there is no dataset yet; the message says how many, and what to do."""


def collect(store: UnitStore, scenario: Scenario) -> Path:
    """Merge every unit of `scenario` into one file, `<store>/solutions.parquet`, and return its path.

    Rows are sorted by split, task (speed fastest), pattern, seed and start. Every part is checked; a bad one goes to
    quarantine.
    Raises NotComplete, WriteError.
    """
    units = plan_units(scenario)
    stored = store.solved()
    missing = sum(unit.digest not in stored for unit in units)
    if missing:
        raise NotComplete(f"{scenario.name}: {missing} of {len(units)} units are not solved yet; solve them first")
    damaged = store.validate_all(units)
    if damaged:
        raise NotComplete(
            f"{scenario.name}: {len(damaged)} damaged part(s) went to {store.folder / 'quarantine'}; solve again. "
            f"The first: {next(iter(damaged.values()))}"
        )
    try:
        schema = solution_schema(scenario.as_data())
        table, records = _scalars(store, units, scalar_columns(schema.names))
        rows = table.to_pandas().sort_values(_order(schema.names), kind="stable", ignore_index=True)
        target = store.folder / FILE_NAME
        read = functools.lru_cache(maxsize=OPEN_PARTS)(lambda index: store.read(units[index]))
        with new_file(target, replace=True) as file:
            record = dataset_record(scenario, [unit.digest for unit in units], records)
            write_sealed(file, schema, _tables(rows, read, schema), record)
    except DamagedPart as error:
        raise NotComplete(f"{scenario.name}: a part changed while it was collected: {error}") from None
    return target


def thin(collected: Path, target: Path, costs: pd.DataFrame, gaits: int, dearer: float) -> Path:
    """Copy a collected file to a size that can be published; the rows stay, most of the motions go.

    `costs` are those of its gaits (`gaitflow.dataset.labels.gait_costs`). Of each task the `gaits` cheapest gaits keep
    the trajectory of their pattern's cheapest solve. Of these the ones that are at most the share `dearer` dearer than
    the best keep multipliers, in single precision, which is enough to start a solve. Raises ValueError when `collected`
    is damaged or not ours, WriteError.
    """
    check_seal(collected)
    with pq.ParquetFile(collected) as file, new_file(target, replace=True) as thinned:
        record = read_record(file.metadata.metadata, str(collected))
        schema = file.schema_arrow.remove_metadata()
        rows = file.read(columns=scalar_columns(schema.names)).to_pandas()
        motion, near = _worth_keeping(rows, costs, gaits, dearer)

        def tables() -> Iterator[pa.Table]:
            start = 0
            for batch in file.iter_batches(batch_size=ROWS_PER_GROUP):
                here = slice(start, start + len(batch))
                columns = [_kept(batch[name], name, motion[here], near[here]) for name in schema.names]
                yield pa.Table.from_arrays(columns, schema=schema)
                start += len(batch)

        write_sealed(thinned, schema, tables(), record, PUBLISHED_LEVEL)
    return target


def _kept(column: pa.Array, name: str, motion: Mask, near: Mask) -> pa.Array:
    """A column of a batch, with nulls in the rows that are to lose it."""
    if name not in HEAVY:
        return column
    kept = near if name in MULTIPLIERS else motion
    column = column.take(pa.array(np.arange(len(column)), mask=~kept))
    if name in MULTIPLIERS:
        column = column.cast(pa.list_(pa.float32())).cast(column.type)
    return column


def _scalars(store: UnitStore, units: Sequence[Unit], columns: Sequence[str]) -> tuple[pa.Table, list[dict[str, Any]]]:
    """Scalar columns of all rows, with where each row is: `unit` (index) and `row` in its part; what made the parts.

    Of the parts' records only those that differ in who made them how: one a part would not fit into memory.
    """
    tables, makers = [], dict[str, dict[str, Any]]()
    for index, unit in enumerate(units):
        table, record = store.read_with_record(unit, columns=columns)
        made = {key: record[key] for key in MAKERS}
        makers[json.dumps(made, sort_keys=True)] = made
        places = pa.array(np.full(len(table), index)), pa.array(np.arange(len(table)))
        table = table.replace_schema_metadata().append_column("unit", places[0]).append_column("row", places[1])
        tables.append(table)
        if len(tables) == TABLES_AT_ONCE:  # a table has a price beside that of its rows
            tables = [pa.concat_tables(tables).combine_chunks()]
    return pa.concat_tables(tables), list(makers.values())


def _worth_keeping(rows: pd.DataFrame, costs: pd.DataFrame, gaits: int, dearer: float) -> tuple[Mask, Mask]:
    """Which rows [n] are of their task's cheapest gaits; which of these are nearly as cheap as the best."""
    task = task_columns(rows.columns)
    key = [*task, "pattern"]
    chosen = costs.sort_values([*task, "excess"], kind="stable").groupby(task).head(gaits)
    excess = {tuple(row[:-1]): row[-1] for row in chosen[[*key, "excess"]].itertuples(index=False)}
    solved = rows[rows["status"] == "solved"].sort_values(["cost", *_order(rows.columns)], kind="stable")
    best = solved.drop_duplicates(key)
    found = {
        index: excess.get(tuple(row), np.inf)
        for index, row in zip(best.index, best[key].itertuples(index=False), strict=True)
    }
    kept = np.array([found.get(index, np.inf) for index in rows.index])
    return np.isfinite(kept), kept <= dearer


def _order(names: Iterable[str]) -> list[str]:
    *axes, split = task_columns(names)
    return [split, *reversed(axes), "pattern", "seed", "start"]


def _tables(rows: pd.DataFrame, read: Callable[[int], pa.Table], schema: pa.Schema) -> Iterator[pa.Table]:
    for start in range(0, len(rows), ROWS_PER_GROUP):
        block = rows.iloc[start : start + ROWS_PER_GROUP]
        # One piece per part, then into the block's order.
        pieces, places = [], []
        for index, members in block.groupby("unit", sort=True):
            part = read(int(index))  # type: ignore[arg-type]
            pieces.append(part.select(schema.names).cast(schema).take(pa.array(members["row"])))
            places.append(members.index.to_numpy() - start)
        order = np.argsort(np.concatenate(places))
        yield pa.concat_tables(pieces).take(pa.array(order)).combine_chunks()
