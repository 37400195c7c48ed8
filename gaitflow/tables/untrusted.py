"""Parquet files that anybody may have written: opened where they are said to be, read within bounds.

Whatever is wrong with a file is a ValueError of one line that names it. What its columns must be only its readers know.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.files import inside

ROWS_AT_ONCE = 4096
PIECE = 1 << 28  # bytes that the texts of rows read at once may unpack to


def file_in(path: Path, name: str) -> Path:
    """`path`, or where that is a folder its file of this name.

    Raises FileNotFoundError when there is none, ValueError when the name in the folder is a link that leads elsewhere.
    """
    file_path = inside(path, name) if path.is_dir() else path
    if not file_path.is_file():
        raise FileNotFoundError(f"{file_path}: no such dataset; give a .parquet file or the folder of one version")
    return file_path


@contextmanager
def opened(path: Path, most_rows: int) -> Iterator[pq.ParquetFile]:
    """A Parquet file of at most so many rows, whose columns have different names."""
    try:
        with pq.ParquetFile(path) as file:
            names, rows = file.schema_arrow.names, file.metadata.num_rows
            if len(set(names)) < len(names):
                raise ValueError(f"{path}: two columns have one name")
            if not 0 <= rows <= most_rows:
                raise ValueError(f"{path}: has {rows} rows; it may have at most {most_rows}")
            yield file
    except MemoryError:  # pyarrow's, too
        raise ValueError(f"{path}: unpacks to more than this machine's memory") from None
    except (pa.ArrowException, OSError) as error:
        reason = " ".join(str(error).split())[:200]
        told = reason if reason.isprintable() else repr(reason)  # it may repeat bytes of the file
        raise ValueError(f"{path}: not a readable Parquet file ({told})") from None


def read_table(file: pq.ParquetFile, path: Path, most_bytes: int) -> pa.Table:
    """All rows, unpacked piece by piece to at most so many bytes. Raises ValueError as `opened` does, around it.

    Lists of a fixed size come as lists without one: those would take their place in rows without a value, too.
    """
    fixed = 8 * sum(kind.list_size for kind in file.schema_arrow.types if pa.types.is_fixed_size_list(kind))
    if file.metadata.num_rows * fixed > most_bytes:  # which takes time, if not memory
        raise ValueError(f"{path}: {file.metadata.num_rows} rows unpack to more than {most_bytes} bytes")
    pieces, size = list[pa.RecordBatch](), 0
    for piece in file.iter_batches(batch_size=_rows_at_once(file.metadata, fixed), use_threads=False):
        pieces.append(_compact(piece))
        size += pieces[-1].nbytes
        if size > most_bytes:
            raise ValueError(f"{path}: unpacks to more than {most_bytes} bytes")
    return pa.Table.from_batches(pieces, _compact_schema(file.schema_arrow))


def _rows_at_once(told: pq.FileMetaData, fixed: int) -> int:
    """How many rows to unpack at once: a text that is kept once may be in each of them, as long as all that is kept.

    `fixed` are the bytes of a row's lists of a fixed size.
    """
    groups = [told.row_group(i) for i in range(told.num_row_groups)]
    columns = [[group.column(i) for i in range(group.num_columns)] for group in groups]
    kept = [sum(each.total_uncompressed_size for each in own if each.physical_type == "BYTE_ARRAY") for own in columns]
    return max(1, min(ROWS_AT_ONCE, PIECE // max([1, *kept, fixed])))


def _compact(piece: pa.RecordBatch) -> pa.RecordBatch:
    """The same rows, in which lists of a fixed size take no place where there is no value."""
    columns = list(piece.columns)
    for number, column in enumerate(columns):
        if pa.types.is_fixed_size_list(column.type):
            present = np.asarray(column.is_valid())
            ends = np.concatenate([[0], np.cumsum(present) * column.type.list_size]).astype(np.int32)
            columns[number] = pa.ListArray.from_arrays(ends, column.flatten(), mask=pa.array(~present))
    return pa.RecordBatch.from_arrays(columns, schema=_compact_schema(piece.schema))


def _compact_schema(schema: pa.Schema) -> pa.Schema:
    fields = [
        field.with_type(pa.list_(field.type.value_field)) if pa.types.is_fixed_size_list(field.type) else field
        for field in schema
    ]
    return pa.schema(fields, schema.metadata)
