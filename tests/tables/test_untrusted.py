"""Parquet files that anybody may have written, read within bounds."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from gaitflow.tables.untrusted import opened, read_table

SIZE = 1000


def written(path: Path, values: list[list[float] | None]) -> pa.Table:
    field = pa.field("base", pa.list_(pa.float64(), SIZE), metadata={"unit": "m"})
    table = pa.table({"base": pa.array(values, field.type)}, schema=pa.schema([field], {"what": "a test"}))
    pq.write_table(table, path)
    return table


def read(path: Path, most_bytes: int = 1 << 30) -> pa.Table:
    with opened(path, 10_000) as file:
        return read_table(file, path, most_bytes)


@pytest.mark.parametrize("piece", [1 << 28, 3 * 8 * SIZE])
def test_rows_without_a_value_take_no_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, piece: int) -> None:
    """Of a dataset that is published most rows have no motion, and a motion is a list of a fixed size."""
    monkeypatch.setattr("gaitflow.tables.untrusted.PIECE", piece)
    values = [[float(row)] * SIZE if row % 100 == 7 else None for row in range(1000)]
    table, found = written(tmp_path / "file.parquet", values), read(tmp_path / "file.parquet")
    assert found["base"].to_pylist() == table["base"].to_pylist()
    assert found.nbytes < 2 * 10 * 8 * SIZE < table.nbytes
    assert found.schema.metadata[b"what"] == b"a test" and found.schema.field("base").metadata == {b"unit": b"m"}


@pytest.mark.parametrize("values", [[], [None, None], [[1.0] * SIZE]])
def test_files_of_few_rows(tmp_path: Path, values: list[list[float] | None]) -> None:
    written(tmp_path / "file.parquet", values)
    assert read(tmp_path / "file.parquet")["base"].to_pylist() == values


def test_what_would_unpack_to_too_much_is_refused_before(tmp_path: Path) -> None:
    written(tmp_path / "file.parquet", [None] * 1000)
    with pytest.raises(ValueError, match=r"file\.parquet: 1000 rows unpack to more than 1000000 bytes"):
        read(tmp_path / "file.parquet", 1_000_000)
