"""Damaged datasets, sealed again: read whole, listed, and searched for a motion."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.hostile import fields, folders
from benchmarks.hostile.damage import Damage, damaged_bytes
from benchmarks.hostile.sandbox import Unsound
from gaitflow.dataset import load_solutions
from gaitflow.dataset.labels_file import FILE_NAME as LABELS
from gaitflow.dataset.labels_file import read_labels
from gaitflow.dataset.read import FILE_NAME
from gaitflow.publishing.dataset import read_manifest
from gaitflow.report import stored
from gaitflow.tables.seal import BrokenSeal, seal, write_sealed

REFUSALS = (ValueError, FileNotFoundError)
MANIFEST = "manifest.json"
EMPTY_ROWS = 3_000_000
WAYS = (
    "drop", "rename", "twice", "text", "null", "number", "number", "number", "empty", "none", "extra", "list",
    "one long text", "many long texts",
)  # fmt: skip
LONG_TEXT, LONG_TEXTS = 1_000_000, 3000
ODD_NUMBERS = (1e308, float("nan"), float("inf"), -1.0, 0.0, 1e30)


def damages(sounds: Sequence[Path]) -> Iterator[tuple[int, Damage]]:
    """Every field of the record and the manifest in every way, and columns, bytes and places at random."""
    for number, folder in enumerate(sounds):
        manifest = json.loads((folder / MANIFEST).read_bytes())
        for name, data in ((MANIFEST, manifest), (FILE_NAME, _record(folder / FILE_NAME))):
            for path in fields.fields_of(data):
                for oddity in fields.oddities_of(data, path):
                    place = f"{name} {'.'.join(map(str, path))}"
                    yield number, Damage(f"{name} field {oddity}", place, partial(_damage_field, name, path, oddity))
        for what, (times, do) in _AT_RANDOM.items():
            yield from [(number, Damage(what, "", do))] * times


def ask(folder: Path) -> Any:
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


def _damage_field(name: str, path: fields.Path, oddity: str, folder: Path, outside: Path, chance: random.Random) -> str:
    if name == MANIFEST:
        data = fields.damaged_field(json.loads((folder / name).read_bytes()), path, oddity)
        (folder / name).write_text(json.dumps(data), encoding="utf-8")
    else:
        data = fields.damaged_field(_record(folder / name), path, oddity)
        _write(folder / name, pq.read_table(folder / name), data)
    return ""


def _damage_table(folder: Path, outside: Path, chance: random.Random) -> str:
    path = folder / chance.choice([FILE_NAME, LABELS])
    how, table = _damaged_table(pq.read_table(path), chance)
    _write(path, table, _record(path))
    return f"{path.name} {how}"


def _damage_bytes(folder: Path, outside: Path, chance: random.Random) -> str:
    """Anywhere, or in the footer, where a file says what is where."""
    path = folder / chance.choice([FILE_NAME, LABELS])
    content = path.read_bytes()
    tail = chance.choice([64, 8192, len(content)])
    how, damaged = damaged_bytes(content[-tail:], chance)
    path.write_bytes(content[:-tail] + damaged)
    if path.name == FILE_NAME and chance.random() < 0.7:
        _seal_again(path)
    return f"{path.name} {how}"


def _damage_place(folder: Path, outside: Path, chance: random.Random) -> str:
    files = sorted(each for each in folder.iterdir() if each.is_file())
    return folders.damaged(chance.choice(files), files, outside, chance)


_AT_RANDOM: dict[str, tuple[int, Callable[[Path, Path, random.Random], str]]] = {
    "column": (200, _damage_table),
    "bytes": (100, _damage_bytes),
    "file": (40, _damage_place),
}


def _record(path: Path) -> Any:
    """What a table says of itself; labels say nothing."""
    return json.loads((pq.read_metadata(path).metadata or {}).get(b"gaitflow", b"{}"))


def _write(path: Path, table: pa.Table, record: Any) -> None:
    if path.name == LABELS:
        plain = not any(pa.types.is_dictionary(each.type) for each in table.schema)
        pq.write_table(table, path, store_schema=plain)  # without it, text comes back as text
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
    how = chance.choice(WAYS)
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
        case "one long text" | "many long texts":  # kept once in the file, and unpacked for each row
            rows = 1 if how == "one long text" else LONG_TEXTS
            texts = pa.DictionaryArray.from_arrays(np.zeros(rows, dtype=np.int32), pa.array(["x" * LONG_TEXT]))
            table = table.take(np.zeros(rows, dtype=np.int64))
            return how, table.set_column(at, table.schema.field(name).with_type(texts.type), texts)
        case "list":
            lists = pa.array([[1]] * len(table), pa.list_(pa.int8()))
            return how, table.set_column(at, table.schema.field(name).with_type(lists.type), lists)
    values = pa.array(["x"] * len(table))
    return "text", table.set_column(at, table.schema.field(name).with_type(values.type), values)
