"""Merging the parts of a run into one dataset file whose rows do not depend on who solved what when."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.config.scenario import Scenario
from gaitflow.dataset.provenance import dataset_record, read_record
from gaitflow.dataset.read import FILE_NAME
from gaitflow.dataset.schema import HEAVY, SCALARS, Sizes, solution_schema
from gaitflow.files import new_file
from gaitflow.store.parts import DamagedPart, UnitStore
from gaitflow.store.seal import check_seal, write_sealed
from gaitflow.store.units import Unit, plan_units

ORDER = ["split", "cycle_duration", "speed", "pattern", "seed", "start"]
TASK = ["split", "cycle_duration", "speed"]
ROWS_PER_GROUP = 2000  # rows held in memory at a time
OPEN_PARTS = 8
TABLES_AT_ONCE = 1000
MAKERS = ("made_by", "solver_options")  # what a dataset's record keeps of those of its parts


class NotComplete(ValueError):
    """Units are missing or damaged, so that there is no dataset yet; the message says how many, and what to do."""


def collect(store: UnitStore, scenario: Scenario) -> Path:
    """Merge every unit of `scenario` into one file, `<store>/solutions.parquet`, and return its path.

    Rows are sorted by (split, T, v, pattern, seed, start). Every part is checked; a bad one goes to quarantine.
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
        table, records = _scalars(store, units)
        rows = table.to_pandas().sort_values(ORDER, kind="stable", ignore_index=True)
        target = store.folder / FILE_NAME
        read = functools.lru_cache(maxsize=OPEN_PARTS)(lambda index: store.read(units[index]))
        schema = solution_schema(Sizes.of(scenario))
        with new_file(target, replace=True) as file:
            record = dataset_record(scenario, [unit.digest for unit in units], records)
            write_sealed(file, schema, _tables(rows, read, schema), record)
    except DamagedPart as error:
        raise NotComplete(f"{scenario.name}: a part changed while it was collected: {error}") from None
    return target


def thin(collected: Path, target: Path, keep_trajectories: int) -> Path:
    """Copy a collected file to a size that can be published.

    Only the cheapest solved row of each of the `keep_trajectories` cheapest gaits of a task keeps its trajectory and
    multipliers; the others have nulls there. Raises ValueError when `collected` is damaged or not ours, WriteError.
    """
    check_seal(collected)
    with pq.ParquetFile(collected) as file, new_file(target, replace=True) as thinned:
        record = read_record(file.metadata.metadata, str(collected))
        keep = _cheapest(file.read(columns=list(SCALARS)).to_pandas(), keep_trajectories).to_numpy(dtype=bool)
        schema = file.schema_arrow.remove_metadata()

        def tables() -> Iterator[pa.Table]:
            start = 0
            for batch in file.iter_batches(batch_size=ROWS_PER_GROUP):
                chosen = pa.array(np.arange(len(batch)), mask=~keep[start : start + len(batch)])
                columns = [batch[name].take(chosen) if name in HEAVY else batch[name] for name in schema.names]
                yield pa.Table.from_arrays(columns, schema=schema)
                start += len(batch)

        write_sealed(thinned, schema, tables(), record)
    return target


def _scalars(store: UnitStore, units: Sequence[Unit]) -> tuple[pa.Table, list[dict[str, Any]]]:
    """Scalar columns of all rows, with where each row is: `unit` (index) and `row` in its part; what made the parts.

    Of the parts' records only those that differ in who made them how: one a part would not fit into memory.
    """
    tables, makers = [], dict[str, dict[str, Any]]()
    for index, unit in enumerate(units):
        table, record = store.read_with_record(unit, columns=list(SCALARS))
        made = {key: record[key] for key in MAKERS}
        makers[json.dumps(made, sort_keys=True)] = made
        places = pa.array(np.full(len(table), index)), pa.array(np.arange(len(table)))
        table = table.replace_schema_metadata().append_column("unit", places[0]).append_column("row", places[1])
        tables.append(table)
        if len(tables) == TABLES_AT_ONCE:  # a table has a price beside that of its rows
            tables = [pa.concat_tables(tables).combine_chunks()]
    return pa.concat_tables(tables), list(makers.values())


def _cheapest(rows: pd.DataFrame, number: int) -> pd.Series:
    solved = rows[rows["status"] == "solved"].sort_values(["cost", *ORDER], kind="stable")
    best = solved.drop_duplicates([*TASK, "gait"])
    return pd.Series(rows.index.isin(best.groupby(TASK).head(number).index), index=rows.index)


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
