from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import NotComplete, collect
from gaitflow.search.solution import Solution
from gaitflow.store import compact as module
from gaitflow.store.compact import NotPacked, compact
from gaitflow.store.known_parts import validate_changed
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

Make = Callable[[Unit], list[Solution]]
KILLED = 9


@pytest.fixture
def full(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make) -> UnitStore:
    for unit in units:
        store.write(unit, make_solutions(unit), {})
    return store


def bytes_of(store: UnitStore, units: tuple[Unit, ...]) -> dict[str, bytes]:
    return {unit.digest: store.part(unit.digest) for unit in units}


def packs(store: UnitStore) -> list[Path]:
    return sorted((store.folder / "packs").glob("*.pack"))


def test_packed_parts_are_the_same_parts(
    full: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    before = bytes_of(full, units)
    dataset = load_solutions(collect(full, scenario)).frame()
    done = compact(full)
    assert (done.parts, done.packs, done.damaged) == (len(units), 1, {})
    assert done.bytes == packs(full)[0].stat().st_size > sum(map(len, before.values()))
    again = UnitStore(full.folder)
    assert list(again.loose()) == [] and again.solved() == set(before)
    assert all(again.has(unit) for unit in units) and bytes_of(again, units) == before
    assert not again.write(units[0], make_solutions(units[0]), {}), "what is packed is stored"
    assert again.validate_all(units) == {}
    assert load_solutions(collect(again, scenario)).frame().equals(dataset)
    assert compact(again).packs == 0


def test_later_parts_make_another_pack_and_large_ones_are_split(
    store: UnitStore, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    for unit in units[:3]:
        store.write(unit, make_solutions(unit), {})
    assert compact(store).parts == 3
    store.write(units[3], make_solutions(units[3]), {})
    assert compact(store).parts == 0 and len(list(store.loose())) == 1, "a pack of one part is no gain"
    for unit in units[4:]:
        store.write(unit, make_solutions(unit), {})
    size = max(store.path(name[:64]).stat().st_size for name in store.loose())
    done = compact(store, max_bytes=2 * size)
    assert done.packs >= 1 and store.solved() == {unit.digest for unit in units}
    assert all(path.stat().st_size < 2 * size + 1000 for path in packs(store)[-done.packs :]) or len(packs(store)) > 1


def test_a_damaged_small_file_is_not_packed(full: UnitStore, units: tuple[Unit, ...]) -> None:
    part = full.path(units[0].digest)
    part.write_bytes(part.read_bytes()[:-5])
    shutil.copy(full.path(units[1].digest), full.path(units[2].digest))
    done = compact(full)
    assert set(done.damaged) == {units[0].digest, units[2].digest} and done.parts == len(units) - 2
    assert "foreign" in done.damaged[units[2].digest]
    assert full.solved() == {unit.digest for unit in units} - set(done.damaged)
    assert len(list((full.folder / "quarantine").glob("*.parquet"))) == 2


def flip(path: Path, at: int) -> None:
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)


def test_a_bad_part_breaks_up_its_pack_and_costs_one_unit(
    full: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    before = bytes_of(full, units)
    compact(full)
    (pack,) = packs(full)
    flip(pack, -200)  # in the last part
    last = max(before)
    with pytest.raises(NotComplete, match=r"1 damaged part\(s\) went to"):
        collect(full, scenario)
    assert packs(full) == [] and full.solved() == set(before) - {last}
    assert {digest: full.part(digest) for digest in full.solved()} == {d: before[d] for d in before if d != last}
    assert [file.name[:64] for file in (full.folder / "quarantine").glob("*.pack")] == [pack.stem]
    (unit,) = (unit for unit in units if unit.digest == last)
    assert full.write(unit, make_solutions(unit), {})
    assert full.validate_all(units) == {}


def test_a_pack_with_a_bad_index_holds_nothing_and_is_set_aside(full: UnitStore, units: tuple[Unit, ...]) -> None:
    compact(full)
    (pack,) = packs(full)
    flip(pack, 40)
    again = UnitStore(full.folder)
    assert again.solved() == frozenset() and not again.has(units[0])
    (reason,) = again.set_aside_damaged_packs()
    assert "its index does not match its name" in reason and packs(full) == []
    assert [file.read_text().strip() for file in (full.folder / "quarantine").glob("*.txt")] == [reason]


def test_what_was_found_sound_is_not_read_again_after_packing(
    full: UnitStore, units: tuple[Unit, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    validate_changed(full, units[:4])
    compact(full)
    read: list[str] = []
    monkeypatch.setattr(UnitStore, "validate", lambda store, unit: read.append(unit.digest))
    validate_changed(full, units)
    assert sorted(read) == sorted(unit.digest for unit in units[4:])


def test_a_pack_that_comes_back_different_removes_nothing(
    full: UnitStore, units: tuple[Unit, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = bytes_of(full, units)
    monkeypatch.setattr(module, "_forget", lambda path: flip(path, -300))
    with pytest.raises(NotPacked, match="the small files are kept"):
        compact(full)
    assert len(list(full.loose())) == len(units) and bytes_of(full, units) == before


@pytest.mark.slow
def test_a_kill_at_any_step_loses_nothing(
    full: UnitStore, units: tuple[Unit, ...], tmp_path: Path, checkout: Path
) -> None:
    before, undisturbed = bytes_of(full, units), tmp_path / "undisturbed"
    shutil.copytree(full.folder, undisturbed)
    compact(UnitStore(undisturbed))
    code, step = KILLED, 0
    while code == KILLED:
        step += 1
        code = one_kill(full, units, tmp_path / f"killed-{step}", step, before, checkout)
    assert code == 0
    assert step > 4 * len(units), "each part is looked for, read, read back and removed"


def test_a_kill_between_removals_is_finished_by_the_next_compaction(
    full: UnitStore, units: tuple[Unit, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = bytes_of(full, units)
    unlink, removed = Path.unlink, list[Path]()

    def killed(path: Path, missing_ok: bool = False) -> None:
        if path.suffix == ".parquet":
            removed.append(path)
            if len(removed) == 3:
                raise KeyboardInterrupt
        unlink(path, missing_ok)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Path, "unlink", killed)
        compact(full)
    assert len(list(full.loose())) == len(units) - 2 and len(packs(full)) == 1
    assert bytes_of(full, units) == before and full.solved() == set(before)
    assert compact(full).packs == 0 and list(full.loose()) == []
    assert bytes_of(full, units) == before


def one_kill(
    full: UnitStore, units: tuple[Unit, ...], folder: Path, step: int, before: dict[str, bytes], checkout: Path
) -> int:
    shutil.copytree(full.folder, folder)
    program = checkout / "tests/store/killed_compaction.py"
    code = subprocess.run([sys.executable, str(program), str(folder), str(step)], env=os.environ, timeout=60).returncode
    store = UnitStore(folder)
    assert store.solved() == set(before), f"killed at step {step}"
    assert bytes_of(store, units) == before
    compact(store)
    assert store.solved() == set(before) and bytes_of(store, units) == before
    assert list(store.loose()) == [] and len(packs(store)) == 1 and store.validate_all(units) == {}
    shutil.rmtree(folder)
    return code
