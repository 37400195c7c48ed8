from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pyarrow.parquet as pq
import pytest

from gaitflow.files import WriteError
from gaitflow.search.solution import Solution
from gaitflow.store.parts import DamagedPart, UnitStore
from gaitflow.store.units import Unit
from gaitflow.tables.provenance import read_record
from gaitflow.tables.seal import write_sealed
from gaitflow.tables.solutions import solutions_to_table, table_to_solutions

Make = Callable[[Unit], list[Solution]]
OPTIONS = {"ipopt": {"tol": 1e-9}}


def quarantined(store: UnitStore) -> dict[str, str]:
    return {file.stem[:64]: file.read_text() for file in (store.folder / "quarantine").glob("*.txt")}


def test_what_is_written_is_listed_and_read(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> None:
    assert store.solved() == frozenset() and not store.has(units[0])
    assert store.write(units[0], make_solutions(units[0]), OPTIONS)
    assert store.solved() == {units[0].digest} and store.has(units[0])
    costs = [row.cost for row in table_to_solutions(store.read(units[0]), units[0].scenario.as_data())]
    assert repr(costs) == repr([row.cost for row in make_solutions(units[0])])


def test_record_tells_unit_code_versions_and_options(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    store.write(units[0], make_solutions(units[0]), OPTIONS)
    record = read_record(pq.read_metadata(store.path(units[0].digest)).metadata, "part")
    assert Unit.from_data(record["unit"]) == units[0]
    assert record["solver_options"] == OPTIONS
    made_by = record["made_by"]
    assert made_by["packages"]["casadi"] and made_by["python"] and made_by["cpu"] and made_by["code"]["solver"]
    assert os.uname().nodename not in str(record)


def test_first_complete_file_wins(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> None:
    with ThreadPoolExecutor(4) as pool:
        won = list(pool.map(lambda _: store.write(units[0], make_solutions(units[0]), OPTIONS), range(4)))
    assert sorted(won) == [False, False, False, True]
    assert os.listdir(store.path(units[0].digest).parent) == [f"{units[0].digest}.parquet"]


def test_names_that_are_no_parts_are_not_listed(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    store.write(units[0], make_solutions(units[0]), OPTIONS)
    part = store.path(units[0].digest)
    (part.parent / f".{part.name}.1-ab.tmp").write_bytes(b"half")
    (part.parent / "notes.txt").write_bytes(b"")
    (store.folder / "units" / "readme").write_bytes(b"")
    assert store.solved() == {units[0].digest}


@pytest.mark.parametrize("where", [0.0, 0.3, 0.9, 0.999])
def test_a_flipped_bit_goes_to_quarantine(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Make, where: float
) -> None:
    store.write(units[0], make_solutions(units[0]), OPTIONS)
    part = store.path(units[0].digest)
    data = bytearray(part.read_bytes())
    data[int(where * (len(data) - 1))] ^= 4
    part.write_bytes(data)
    with pytest.raises(DamagedPart, match=units[0].digest):
        store.read(units[0])
    assert store.validate(units[0])
    assert not store.has(units[0]) and units[0].digest in quarantined(store)


def test_a_truncated_part_goes_to_quarantine_and_can_be_solved_again(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    for unit in units[:2]:
        store.write(unit, make_solutions(unit), OPTIONS)
    part = store.path(units[0].digest)
    part.write_bytes(part.read_bytes()[:-100])
    assert set(store.validate_all(units)) == {units[0].digest}
    assert "truncated" in quarantined(store)[units[0].digest]
    assert store.solved() == {units[1].digest}
    assert store.write(units[0], make_solutions(units[0]), OPTIONS)
    assert store.validate_all(units) == {}


def test_the_part_of_another_unit_is_foreign(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> None:
    store.write(units[0], make_solutions(units[0]), OPTIONS)
    store.path(units[1].digest).parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(store.path(units[0].digest), store.path(units[1].digest))
    reason = store.validate(units[1])
    assert reason and "foreign: it holds the unit" in reason
    assert store.validate(units[0]) is None


def test_a_part_of_another_schema_is_foreign(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> None:
    unit = units[0]
    store.write(unit, make_solutions(unit), OPTIONS)
    part = store.path(unit.digest)
    record = read_record(pq.read_metadata(part).metadata, "part")
    table = solutions_to_table(make_solutions(unit), unit.scenario.as_data()).drop_columns(["violation"])
    part.unlink()
    with open(part, "xb+") as file:
        write_sealed(file, table.schema, [table], record)
    assert "foreign: columns differ: violation" in (store.validate(unit) or "")


@pytest.mark.parametrize("content", [b"", b"hello", b"PAR1" + b"\xff" * 60 + b"PAR1"])
def test_what_is_not_parquet_goes_to_quarantine(store: UnitStore, units: tuple[Unit, ...], content: bytes) -> None:
    part = store.path(units[0].digest)
    part.parent.mkdir(parents=True)
    part.write_bytes(content)
    assert "not a complete Parquet file" in (store.validate(units[0]) or "")


def test_a_full_disk_leaves_nothing_behind(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(WriteError, match=f"{units[0].digest}.parquet: cannot be written .*free some space"):
        store.write(units[0], make_solutions(units[0]), OPTIONS)
    assert [file for file in store.folder.rglob("*") if file.is_file()] == []


def test_rows_of_other_tasks_are_refused(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> None:
    for rows in ([], make_solutions(units[0])[3:], make_solutions(units[0]) + make_solutions(units[1])):
        with pytest.raises(ValueError, match="rows and the unit's tasks differ"):
            store.write(units[0], rows, OPTIONS)
    assert not store.has(units[0])
