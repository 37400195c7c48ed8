"""A seal over every byte of a Parquet file, so that one flipped bit anywhere is found.

Parquet's own page checksums leave its footer open. The seal is a key-value entry of the footer, the SHA-256 of the
whole file with the entry's 64 digits read as zeros: written as zeros, computed, then set in place.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.tables.provenance import KEY as RECORD

KEY = "gaitflow.seal"
MARK = "gaitflow-sha256:"
BLANK = MARK + "0" * 64
_SEAL = re.compile(re.escape(MARK.encode()) + rb"[0-9a-f]{64}")
_MAGIC = b"PAR1"
_CHUNK = 1 << 20


class BrokenSeal(ValueError):
    """A file is truncated, not Parquet, or not the bytes that were sealed."""


def write_sealed(
    file: BinaryIO, schema: pa.Schema, tables: Iterable[pa.Table], record: Mapping[str, Any], level: int | None = None
) -> None:
    """Write tables of one schema as one sealed Parquet file with its record (zstd at `level`, page checksums)."""
    # Numbers of a motion never repeat, but their exponents do: a column of each byte of them is what compresses well.
    lists = [field.name for field in schema if _is_list_of_numbers(field.type)]
    writer = pq.ParquetWriter(
        file,
        schema,
        compression="zstd",
        compression_level=level,
        use_dictionary=[field.name for field in schema if pa.types.is_string(field.type)],
        column_encoding={f"{name}.list.element": "BYTE_STREAM_SPLIT" for name in lists},
        write_page_checksum=True,
    )
    with writer:
        for table in tables:
            writer.write_table(table)
        writer.add_key_value_metadata({RECORD.decode(): json.dumps(record, sort_keys=True), KEY: BLANK})
    seal(file)


def _is_list_of_numbers(kind: pa.DataType) -> bool:
    return (pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind)) and pa.types.is_floating(kind.value_type)


def seal(file: BinaryIO) -> None:
    """Set the seal of a complete Parquet file that carries `KEY: BLANK` in its metadata; open for reading, writing."""
    start = _find(file)
    digits = _digest(file, start)
    file.seek(start)
    file.write(digits.encode())


def check_seal(path: Path) -> None:
    """Raise BrokenSeal unless the file is, byte by byte, what was sealed. Raises OSError when it cannot be read."""
    with open(path, "rb") as file:
        check_open(file, str(path))


def check_open(file: BinaryIO, name: str) -> None:
    """`check_seal` of a file, or of bytes in memory, that is open for reading; `name` is what an error calls it."""
    start = _find(file)
    expected = _digest(file, start)
    file.seek(start)
    if file.read(64) != expected.encode():
        raise BrokenSeal(f"{name}: damaged: its bytes do not match its seal")


def _find(file: BinaryIO) -> int:
    """Offset of the seal's digits, looked for only in the footer."""
    size = file.seek(0, 2)
    name = getattr(file, "name", "file")
    file.seek(max(0, size - 8))
    tail = file.read(8)
    footer = int.from_bytes(tail[:4], "little")
    if size < 12 or tail[4:] != _MAGIC or footer > size - 12:
        raise BrokenSeal(f"{name}: not a complete Parquet file ({size} bytes): truncated, or something else")
    file.seek(size - 8 - footer)
    marks = list(_SEAL.finditer(file.read(footer)))
    if len(marks) != 1:
        raise BrokenSeal(f"{name}: carries {len(marks)} seals, expected one: not written by gaitflow, or damaged")
    return size - 8 - footer + marks[0].start() + len(MARK)


def _digest(file: BinaryIO, start: int) -> str:
    total, left = hashlib.sha256(), start
    file.seek(0)
    while left:
        block = file.read(min(left, _CHUNK))
        if not block:
            raise BrokenSeal(f"{getattr(file, 'name', 'file')}: became shorter while it was read")
        total.update(block)
        left -= len(block)
    total.update(b"0" * 64)
    file.seek(start + 64)
    while block := file.read(_CHUNK):
        total.update(block)
    return total.hexdigest()
