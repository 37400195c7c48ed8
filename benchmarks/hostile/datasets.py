"""Damaged datasets, sealed again: read whole, listed, and searched for a motion."""

from __future__ import annotations

import json
import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.hostile.damage import damaged_bytes, damaged_data
from benchmarks.hostile.sandbox import Unsound
from gaitflow.dataset import load_solutions
from gaitflow.dataset.labels_file import FILE_NAME as LABELS
from gaitflow.dataset.labels_file import read_labels
from gaitflow.dataset.read import FILE_NAME
from gaitflow.publishing.dataset import read_manifest
from gaitflow.report import stored
from gaitflow.tables.seal import BrokenSeal, seal, write_sealed

REFUSALS = (ValueError, FileNotFoundError)
EMPTY_ROWS = 3_000_000
ODD_NUMBERS = (1e308, float("nan"), float("inf"), -1.0, 0.0, 1e30)


def damage(folder: Path, outside: Path, chance: random.Random) -> str:
    """Damage the dataset in a folder and seal it again; what was done."""
    name = chance.choice([FILE_NAME, FILE_NAME, LABELS, LABELS, "manifest.json"])
    path, what = folder / name, chance.choice(["table", "table", "table", "record", "bytes", "link"])
    if name == "manifest.json":
        how, data = damaged_data(json.loads(path.read_bytes()), chance)
        path.write_text(json.dumps(data), encoding="utf-8")
        return f"{name} {how}"
    if what == "link":
        (outside / name).write_bytes(path.read_bytes())
        path.unlink()
        path.symlink_to(outside / name)
    elif what == "bytes":
        how, content = damaged_bytes(path.read_bytes(), chance)
        path.write_bytes(content)
        what = f"bytes {how}"
        if name == FILE_NAME and chance.random() < 0.7:
            _seal_again(path)
    else:
        table = pq.read_table(path)
        record = json.loads((pq.read_metadata(path).metadata or {}).get(b"gaitflow", b"{}"))
        if what == "record" and name == FILE_NAME:
            how, record = damaged_data(record, chance)
        else:
            how, table = _damaged_table(table, chance)
        _write(path, table, record)
        what = f"{what} {how}"
    return f"{name} {what}"


def ask(folder: Path, number: int) -> Any:
    """What the commands `labels` and `show` say of it. Raises ValueError, FileNotFoundError, Unsound."""
    manifest, solutions, labels = read_manifest(folder), load_solutions(folder), read_labels(folder)
    motions = 0
    for row in solutions:
        if row.trajectory is not None:
            motions += 1
            if not all(np.isfinite(each).all() for each in vars(row.trajectory).values()):
                raise Unsound(f"a motion at {row.task.text()} is not finite")
    costs = solutions.frame()["cost"]
    task = stored.nearest_task(solutions, {"speed": 0.9, "cycle_duration": 0.6})
    ranked = stored.ranked_gaits(solutions, task)
    if any(not math.isfinite(each.cost) for each in ranked):
        raise Unsound("a gait's cost is not finite")
    total = str(costs.sum())
    return [manifest.version, len(solutions), motions, total, task.text(), len(ranked), str(labels.to_pylist())]


def _write(path: Path, table: pa.Table, record: Any) -> None:
    if path.name == LABELS:
        pq.write_table(table, path)
        return
    with open(path, "wb+") as file:
        write_sealed(file, table.schema, [table], record)


def _seal_again(path: Path) -> None:
    """The seal of what the file now holds, where it still has a place for one."""
    with open(path, "rb+") as file:
        try:
            seal(file)
        except (BrokenSeal, OSError):
            return


def _damaged_table(table: pa.Table, chance: random.Random) -> tuple[str, pa.Table]:
    name = chance.choice(table.column_names)
    at, column = table.column_names.index(name), table[name]
    how = chance.choice(
        ["drop", "rename", "twice", "text", "null", "number", "number", "number", "empty", "none", "extra", "list"]
    )
    match how:
        case "drop":
            return how, table.drop_columns([name])
        case "rename":
            return how, table.rename_columns([f"{each}x" if each == name else each for each in table.column_names])
        case "twice":
            return how, table.append_column(table.schema.field(name), column)
        case "null":
            some = pa.array([None if chance.random() < 0.3 else True for _ in range(len(table))], pa.bool_())
            kept = column.combine_chunks().take(pa.array([i if each.is_valid else None for i, each in enumerate(some)]))
            return how, table.set_column(at, table.schema.field(name).with_nullable(True), kept)
        case "number" if pa.types.is_float64(column.type) and len(table):
            values = column.to_numpy().copy()
            values[chance.randrange(len(values)) if chance.random() < 0.5 else slice(None)] = chance.choice(ODD_NUMBERS)
            return how, table.set_column(at, table.schema.field(name), pa.array(values, from_pandas=False))
        case "number" if pa.types.is_fixed_size_list(column.type):
            whole = column.combine_chunks()
            values = np.nan_to_num(whole.values.to_numpy(zero_copy_only=False).copy())
            values[:] = chance.choice(ODD_NUMBERS)
            lists = pa.FixedSizeListArray.from_arrays(pa.array(values), type=whole.type, mask=whole.is_null())
            return how, table.set_column(at, table.schema.field(name), lists)
        case "empty":
            flat = [each for each in table.schema if not pa.types.is_nested(each.type)]
            schema = pa.schema([field.with_nullable(True) for field in flat])
            return how, pa.Table.from_arrays([pa.nulls(EMPTY_ROWS, each.type) for each in schema], schema=schema)
        case "none":
            return how, table.slice(0, 0)
        case "extra":
            return how, table.append_column("extra", pa.array([{"a": [1]}] * len(table)))
        case "list":
            lists = pa.array([[1]] * len(table), pa.list_(pa.int8()))
            return how, table.set_column(at, table.schema.field(name).with_type(lists.type), lists)
    values = pa.array(["x"] * len(table))
    return "text", table.set_column(at, table.schema.field(name).with_type(values.type), values)
