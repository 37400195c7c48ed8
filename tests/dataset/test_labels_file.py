from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

from gaitflow.dataset.labels_file import FILE_NAME, MAX_ROWS, read_labels


@pytest.fixture
def published(checkout: Path) -> pa.Table:
    return pq.read_table(checkout / "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0" / FILE_NAME)


def with_column(table: pa.Table, name: str, values: pa.Array) -> pa.Table:
    return table.set_column(table.column_names.index(name), name, values)


def test_labels_come_as_published(checkout: Path, published: pa.Table) -> None:
    folder = checkout / "tests/data/datasets/half-cheetah-slope20-vibration/1.0.0"
    assert read_labels(folder).equals(published.replace_schema_metadata(None))
    assert read_labels(folder / FILE_NAME).num_rows == 4


@pytest.mark.parametrize(
    ("name", "kind", "values", "fault"),
    [
        ("speed", pa.string(), ["fast"] * 4, "column speed is string"),
        ("speed", pa.float64(), [None] * 4, "column speed has rows without a value"),
        ("speed", pa.float64(), [1e308] * 4, "column speed has values beyond"),
        ("cycle_duration", pa.float64(), [float("nan")] * 4, "column cycle_duration has values beyond"),
        ("ties", pa.list_(pa.list_(pa.string())), [[["a"]]] * 4, "column ties is list<element: list"),
        ("ties", pa.list_(pa.string()), [["a", None]] * 4, "column ties has rows without a value"),
        ("status", pa.string(), ["fine"] * 4, "column status has the value 'fine'; allowed: solved"),
        ("cost", pa.bool_(), [True] * 4, "column cost is bool"),
    ],
)
def test_a_column_that_is_none_is_named(
    tmp_path: Path, published: pa.Table, name: str, kind: pa.DataType, values: list[object], fault: str
) -> None:
    pq.write_table(with_column(published, name, pa.array(values, kind)), tmp_path / FILE_NAME)
    with pytest.raises(ValueError, match=rf"{FILE_NAME}: these are no labels: {fault}"):
        read_labels(tmp_path)


def test_a_column_given_twice_is_refused(tmp_path: Path, published: pa.Table) -> None:
    pq.write_table(published.append_column("cost", pc.negate(published["cost"])), tmp_path / FILE_NAME)
    with pytest.raises(ValueError, match="two columns have one name"):
        read_labels(tmp_path)


def test_millions_of_empty_rows_are_refused_unread(tmp_path: Path, published: pa.Table) -> None:
    nothing = {field.name: pa.nulls(MAX_ROWS + 1, field.type) for field in published.schema if field.name != "ties"}
    pq.write_table(pa.table(nothing), tmp_path / FILE_NAME)
    with pytest.raises(ValueError, match=rf"has {MAX_ROWS + 1} rows; it may have at most {MAX_ROWS}"):
        read_labels(tmp_path)


def test_a_text_kept_once_is_not_unpacked_for_each_row_at_once(
    tmp_path: Path, published: pa.Table, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitflow.dataset.labels_file.MAX_BYTES", 50_000_000)
    monkeypatch.setattr("gaitflow.tables.untrusted.PIECE", 10_000_000)
    texts = pa.DictionaryArray.from_arrays(pa.array([0] * 300, pa.int32()), pa.array(["x" * 1_000_000]))
    table = with_column(published.take([0] * 300), "gait", texts)
    pq.write_table(table, tmp_path / FILE_NAME, store_schema=False)
    assert (tmp_path / FILE_NAME).stat().st_size < 200_000
    usual = pa.default_memory_pool()
    counted = pa.proxy_memory_pool(usual)
    pa.set_memory_pool(counted)
    try:
        with pytest.raises(ValueError, match="unpacks to more than 50000000 bytes"):
            read_labels(tmp_path)
    finally:
        pa.set_memory_pool(usual)
    assert counted.max_memory() < 150_000_000


def test_a_footer_of_odd_bytes_is_told_in_one_line(tmp_path: Path, published: pa.Table) -> None:
    pq.write_table(published, tmp_path / FILE_NAME)
    data = bytearray((tmp_path / FILE_NAME).read_bytes())
    data[-8 - int.from_bytes(data[-8:-4], "little")] = 0x1F  # a field of a type that there is not
    (tmp_path / FILE_NAME).write_bytes(data)
    with pytest.raises(ValueError, match="not a readable Parquet file") as caught:
        read_labels(tmp_path)
    assert str(caught.value).isprintable()


def test_a_link_out_of_the_folder_is_not_followed(tmp_path: Path, published: pa.Table) -> None:
    pq.write_table(published, tmp_path / "elsewhere.parquet")
    (tmp_path / "1.0.0").mkdir()
    (tmp_path / "1.0.0" / FILE_NAME).symlink_to(tmp_path / "elsewhere.parquet")
    with pytest.raises(ValueError, match="leads out of"):
        read_labels(tmp_path / "1.0.0")
