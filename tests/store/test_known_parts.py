from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from gaitflow.search.solution import Solution
from gaitflow.store.known_parts import remember, remembered, stamp, validate_changed
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

Make = Callable[[Unit], list[Solution]]


@pytest.fixture
def full(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> UnitStore:
    for unit in units[:4]:
        store.write(unit, make_solutions(unit), {})
    return store


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Digests of the parts that are read, as they are read."""
    seen: list[str] = []
    part = UnitStore.part

    def watched(store: UnitStore, digest: str) -> bytes:
        seen.append(digest)
        return part(store, digest)

    monkeypatch.setattr(UnitStore, "part", watched)
    return seen


def test_a_part_is_read_once(full: UnitStore, units: tuple[Unit, ...], read: list[str], make_solutions: Make) -> None:
    assert validate_changed(full, units) == {}
    assert sorted(read) == sorted(unit.digest for unit in units[:4])
    read.clear()
    assert validate_changed(UnitStore(full.folder), units) == {} and read == []
    full.write(units[4], make_solutions(units[4]), {})
    assert validate_changed(full, units) == {} and read == [units[4].digest]


def test_a_part_that_changed_is_read_again(full: UnitStore, units: tuple[Unit, ...], read: list[str]) -> None:
    validate_changed(full, units)
    read.clear()
    part = full.path(units[1].digest)
    part.write_bytes(part.read_bytes()[:-9])
    assert list(validate_changed(full, units)) == [units[1].digest] == read
    assert not full.has(units[1]) and list((full.folder / "quarantine").glob(f"{units[1].digest}-*.parquet"))
    assert validate_changed(full, units) == {}


def test_what_hides_from_the_cache_does_not_hide_from_a_full_check(full: UnitStore, units: tuple[Unit, ...]) -> None:
    validate_changed(full, units)
    path = full.path(units[2].digest)
    before = path.stat()
    with open(path, "rb+") as file:
        file.seek(100)
        byte = file.read(1)
        file.seek(100)
        file.write(bytes([byte[0] ^ 1]))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert validate_changed(full, units) == {}
    assert list(full.validate_all(units)) == [units[2].digest]


@pytest.mark.parametrize("content", [b"", b"\xff\x00 nonsense\n" * 50, b"a" * 63])
def test_a_damaged_cache_costs_time_only(
    full: UnitStore, units: tuple[Unit, ...], read: list[str], content: bytes
) -> None:
    (full.folder / "checked.txt").write_bytes(content)
    assert validate_changed(full, units) == {} and len(read) == 4
    read.clear()
    assert validate_changed(full, units) == {} and read == []


def test_a_line_cut_short_by_a_kill_is_left_out(full: UnitStore, units: tuple[Unit, ...]) -> None:
    lines = [line for unit in units[:2] if (line := stamp(full, unit.digest))]
    remember(full, lines)
    path = full.folder / "checked.txt"
    path.write_text(path.read_text()[: -len(lines[1]) - 3])
    remember(full, lines[1:])
    assert lines[1] in remembered(full) and remembered(full) <= set(lines)


def test_a_cache_that_cannot_be_written_stops_nothing(full: UnitStore, units: tuple[Unit, ...], tmp_path: Path) -> None:
    (full.folder / "checked.txt").mkdir()
    assert validate_changed(full, units) == {}
    assert stamp(full, "00" * 32) is None
