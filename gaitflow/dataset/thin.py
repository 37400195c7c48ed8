"""Copying a dataset without the motions that matter little, to a size that can be kept beside the code."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from gaitflow.files import new_file
from gaitflow.tables.provenance import read_record
from gaitflow.tables.schema import HEAVY, MULTIPLIERS, row_order, scalar_columns, task_columns
from gaitflow.tables.seal import check_seal, write_sealed

COMPRESSION_LEVEL = 15  # of zstd: what is published is written once
ROWS_AT_ONCE = 2000
MULTIPLIER_BITS = 10  # of the mantissa: three digits, half the bytes of single precision

Mask = NDArray[np.bool_]


def thin(collected: Path, target: Path, costs: pd.DataFrame, gaits: int, dearer: float, tasks: float = 1.0) -> Path:
    """Copy a collected file to a size that can be published; the rows stay, most of the motions go.

    `costs` are those of its gaits (`gaitflow.dataset.labels.gait_costs`). Of each task's `gaits` cheapest gaits those
    that are at most the share `dearer` dearer than the best keep their motion: the trajectory of their pattern's
    cheapest solve, and its multipliers to MULTIPLIER_BITS, which is enough to start a solve. Only the share `tasks` of
    the tasks keep motions, drawn at random among those of one best gait, one of each at least. Raises ValueError when
    `collected` is damaged or not ours, WriteError.
    """
    check_seal(collected)
    with pq.ParquetFile(collected) as file, new_file(target, replace=True) as thinned:
        record = read_record(file.metadata.metadata, str(collected))
        schema = file.schema_arrow.remove_metadata()
        rows = file.read(columns=scalar_columns(schema.names)).to_pandas()
        keep = _cheapest_solves(rows, _of_some_tasks(costs[costs["excess"] <= dearer], tasks), gaits)

        def tables() -> Iterator[pa.Table]:
            start = 0
            for batch in file.iter_batches(batch_size=ROWS_AT_ONCE):
                here = keep[start : start + len(batch)]
                columns = [_kept(batch[name], name, here) for name in schema.names]
                yield pa.Table.from_arrays(columns, schema=schema)
                start += len(batch)

        write_sealed(thinned, schema, tables(), record, COMPRESSION_LEVEL)
    return target


def _kept(column: pa.Array, name: str, keep: Mask) -> pa.Array:
    """A column of a batch; of a motion's, with nulls in the rows that are not to keep it."""
    if name not in HEAVY:
        return column
    column = column.take(pa.array(np.arange(len(column)), mask=~keep))
    return _rounded(column) if name in MULTIPLIERS else column


def _rounded(column: pa.ListArray) -> pa.Array:
    """Lists of numbers rounded to MULTIPLIER_BITS of their mantissas, ties away from 0."""
    numbers = np.asarray(column.flatten(), dtype=np.float32)
    dropped = np.finfo(np.float32).nmant - MULTIPLIER_BITS
    bits = (numbers.view(np.uint32) + np.uint32(1 << dropped - 1)) >> dropped << dropped
    values = pa.array(bits.view(np.float32).astype(np.float64))
    lengths = np.asarray(column.value_lengths().fill_null(0))
    offsets = pa.array(
        np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32), mask=np.append(column.is_null(), False)
    )
    return pa.ListArray.from_arrays(offsets, values).cast(column.type)


def _of_some_tasks(costs: pd.DataFrame, share: float) -> pd.DataFrame:
    """The rows of a share of the tasks, of those of each best gait; equal arguments, equal tasks."""
    task = task_columns(costs.columns)
    best = costs.sort_values([*task, "excess"], kind="stable").drop_duplicates(task)
    shuffled = best.sample(frac=1.0, random_state=0)
    sizes = shuffled.groupby("gait_key")["gait_key"].transform("size")
    kept = shuffled[shuffled.groupby("gait_key").cumcount() < np.ceil(share * sizes)]
    return costs.merge(kept[task], on=task)


def _cheapest_solves(rows: pd.DataFrame, costs: pd.DataFrame, gaits: int) -> Mask:
    """Which rows [n] are the cheapest solve of the pattern of one of their task's `gaits` cheapest gaits."""
    task = task_columns(rows.columns)
    key = [*task, "pattern"]
    first = costs.sort_values([*task, "excess"], kind="stable").groupby(task).head(gaits)
    chosen = set(first[key].itertuples(index=False, name=None))
    solved = rows[rows["status"] == "solved"].sort_values(["cost", *row_order(rows.columns)], kind="stable")
    best = solved.drop_duplicates(key)
    kept = [
        index
        for index, row in zip(best.index, best[key].itertuples(index=False, name=None), strict=True)
        if row in chosen
    ]
    return np.asarray(rows.index.isin(kept), dtype=bool)
