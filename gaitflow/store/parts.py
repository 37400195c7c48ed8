"""The durable store of solved units. It alone says what is done, because whatever moves work may die at any moment.

    <folder>/units/<first 2 digits>/<unit digest>.parquet   one complete, sealed part a unit
    <folder>/packs/<digest>.pack                            many parts in one file, see `pack`; made by `compact`
    <folder>/unfinished/<unit digest>/                      solves of a unit in work, see `solve_record`
    <folder>/attempts/<unit digest>/<n>.json                attempts that killed the solver
    <folder>/quarantine/                                    parts that were damaged or foreign, each with its reason
    <folder>/checked.txt                                    parts that were found sound, see `known_parts`; only a cache

A part is never changed: the first complete file wins. A part that is in `units` and in a pack is the same part.
"""

from __future__ import annotations

import io
import os
import re
import shutil
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.config.scenario import digest_of
from gaitflow.files import atomic_write, new_file, publish_once
from gaitflow.search.solution import Solution
from gaitflow.store.attempts import Attempts
from gaitflow.store.pack import Pack, Packs
from gaitflow.store.units import Unit
from gaitflow.tables import seal
from gaitflow.tables.provenance import read_record, unit_record
from gaitflow.tables.schema import schema_difference, solution_schema
from gaitflow.tables.solutions import solutions_to_table

MAX_PART_BYTES = 4 << 30  # of one file, and of its columns when unpacked
_PART = re.compile(r"[0-9a-f]{64}\.parquet")


class DamagedPart(ValueError):
    """A stored part that cannot be trusted; the message names the file and what is wrong with it."""


class UnitStore:
    """The parts of one run, below `folder` (`runs/<scenario>`). Many processes may use one store at once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.attempts = Attempts(folder / "attempts")
        self.packs = Packs(folder / "packs")
        self._schemas: dict[str, pa.Schema] = {}  # by the unit's problem

    def path(self, digest: str) -> Path:
        """Where the part of a unit is, or will be."""
        return self.folder / "units" / digest[:2] / f"{digest}.parquet"

    def unfinished(self, digest: str) -> Path:
        """The folder of what was solved of a unit that is in work."""
        return self.folder / "unfinished" / digest

    def begun(self) -> frozenset[str]:
        """Digests of units of which something was solved, and that nobody finished."""
        return frozenset(entry.name for entry in _entries(self.folder / "unfinished"))

    def has(self, unit: Unit) -> bool:
        """Whether the unit is solved, or was given up."""
        return self.file(unit.digest) is not None

    def solved(self) -> frozenset[str]:
        """Digests of all stored units, from one listing. A pack whose index is damaged holds none."""
        found = {name[:64] for name in self.loose()}
        for pack in self.packs.all():
            found.update(pack.digests())
        return frozenset(found)

    def loose(self) -> Iterator[str]:
        """Names of all parts that are files of their own."""
        for shelf in _entries(self.folder / "units"):
            if shelf.is_dir():
                yield from (entry.name for entry in _entries(shelf.path) if _PART.fullmatch(entry.name))

    def write(
        self,
        unit: Unit,
        solutions: Sequence[Solution],
        solver_options: Mapping[str, Any],
        maker: Mapping[str, Any] | None = None,
    ) -> bool:
        """Store a unit's solutions durably: False when another process had stored the unit before.

        `maker` says who solved it, as `provenance.made_by` does, where it was not this process.
        Raises WriteError when the disk refuses, ValueError when an array has not the scenario's shape or when the
        solutions are not those of the unit's tasks.
        """
        given = {row.task for row in solutions}
        if given != set(unit.tasks):
            odd = sorted(given ^ set(unit.tasks))
            raise ValueError(f"the solver's rows and the unit's tasks differ, for one in {odd[0]}")
        kept = self.packs.find(unit.digest) is None and self._write(unit, solutions, solver_options, maker)
        shutil.rmtree(self.unfinished(unit.digest), ignore_errors=True)
        return kept

    def read(self, unit: Unit, columns: Sequence[str] | None = None) -> pa.Table:
        """A unit's rows, checked whole: seal, schema, and that it is this unit's. Raises DamagedPart."""
        return self.read_with_record(unit, columns)[0]

    def read_with_record(self, unit: Unit, columns: Sequence[str] | None = None) -> tuple[pa.Table, dict[str, Any]]:
        """`read`, with the part's record (see `provenance.unit_record`). Raises DamagedPart."""
        path = self.path(unit.digest)
        try:
            with pq.ParquetFile(pa.BufferReader(self.part(unit.digest))) as file:
                record = self._check(unit, file, path)
                return file.read(columns=None if columns is None else list(columns), use_threads=False), record
        except DamagedPart:
            raise
        except (pa.ArrowException, OSError, ValueError) as error:
            raise DamagedPart(_naming(path, error)) from None

    def part(self, digest: str) -> bytes:
        """A part's bytes, wherever they are, with their seal checked. Raises DamagedPart."""
        path = self.path(digest)
        try:
            data = self._bytes(digest)
            seal.check_open(io.BytesIO(data), str(path))
        except FileNotFoundError:
            raise DamagedPart(f"{path}: missing; run the solve again") from None
        except (seal.BrokenSeal, OSError) as error:
            raise DamagedPart(_naming(path, error)) from None
        return data

    def validate(self, unit: Unit) -> str | None:
        """None when the unit's part is sound or absent; otherwise move it to quarantine and return the reason.

        A pack with a bad part is broken up: its other parts become files of their own again.
        """
        if not self.has(unit):
            return None
        try:
            self.read(unit, columns=["status"])
        except DamagedPart as error:
            self.quarantine(unit.digest, str(error))
            return str(error)
        return None

    def validate_all(self, units: Iterable[Unit]) -> dict[str, str]:
        """Read and check every stored part of `units`: the digests that went to quarantine, with the reason each."""
        reasons = ((unit.digest, self.validate(unit)) for unit in units)
        return {digest: reason for digest, reason in reasons if reason is not None}

    def file(self, digest: str) -> Path | None:
        """The file that holds a part: its own, or a pack; None when it is not stored."""
        if self.path(digest).is_file():  # looked at first, as `compact` removes it only when its pack is there
            return self.path(digest)
        found = self.packs.find(digest)
        return None if found is None else found[0].path

    def quarantine(self, digest: str, reason: str) -> None:
        """Take a part out of the store, and keep it and the reason in `quarantine`.

        A pack that holds it goes there whole, after its other sound parts became files of their own again.
        """
        if self.path(digest).exists():
            self._set_aside(self.path(digest), digest, reason)
        elif found := self.packs.find(digest):
            self._rescue(found[0], digest)
            self._set_aside(found[0].path, found[0].path.stem, reason)

    def set_aside_damaged_packs(self) -> list[str]:
        """Move packs with a damaged index to quarantine; the reasons. Their units have to be solved again."""
        damaged = self.packs.damaged()
        for path, reason in damaged.items():
            self._set_aside(path, path.stem, reason)
        return list(damaged.values())

    def _write(
        self,
        unit: Unit,
        solutions: Sequence[Solution],
        solver_options: Mapping[str, Any],
        maker: Mapping[str, Any] | None,
    ) -> bool:
        record = unit_record(unit.digest, unit.as_data(), solver_options, maker)
        table = solutions_to_table(solutions, unit.scenario.as_data())
        try:
            with new_file(self.path(unit.digest), replace=False) as file:
                seal.write_sealed(file, table.schema, [table], record)
        except FileExistsError:
            return False
        return True

    def _check(self, unit: Unit, file: pq.ParquetFile, path: Path) -> dict[str, Any]:
        groups = (file.metadata.row_group(i).total_byte_size for i in range(file.metadata.num_row_groups))
        if sum(groups) > MAX_PART_BYTES:
            raise DamagedPart(f"{path}: unpacks to more than {MAX_PART_BYTES} bytes")
        record = read_record(file.metadata.metadata, str(path))
        name = record.get("unit_digest")
        if name != unit.digest or digest_of(record.get("unit")) != unit.digest:
            raise DamagedPart(f"{path}: foreign: it holds the unit {name}, not the one it is named after")
        if unit.problem not in self._schemas:
            self._schemas[unit.problem] = solution_schema(unit.scenario.as_data())
        difference = schema_difference(file.schema_arrow, self._schemas[unit.problem])
        if difference:
            raise DamagedPart(f"{path}: foreign: {difference}")
        return record

    def _bytes(self, digest: str) -> bytes:
        path = self.path(digest)
        try:
            with open(path, "rb") as file:
                size = os.fstat(file.fileno()).st_size
                if size > MAX_PART_BYTES:
                    raise DamagedPart(f"{path}: {size} bytes; a part has at most {MAX_PART_BYTES}")
                return file.read()
        except FileNotFoundError:
            found = self.packs.find(digest)
            if found is None:
                raise
            pack, number = found
            return pack.read(number)

    def _rescue(self, pack: Pack, damaged: str) -> None:
        for number, digest in enumerate(pack.digests()):
            try:
                data = pack.read(number)
                seal.check_open(io.BytesIO(data), digest)
            except (seal.BrokenSeal, OSError):
                continue
            if digest != damaged:
                publish_once(self.path(digest), data)

    def _set_aside(self, path: Path, name: str, reason: str) -> None:
        folder = self.folder / "quarantine"
        folder.mkdir(parents=True, exist_ok=True)
        stem = f"{name}-{time.time_ns()}"
        try:
            os.replace(path, folder / f"{stem}{path.suffix}")
        except FileNotFoundError:
            return  # another process was quicker
        atomic_write(folder / f"{stem}.txt", f"{reason}\n".encode())


def _entries(folder: Path | str) -> Iterator[os.DirEntry[str]]:
    """What is in a folder; nothing when there is none."""
    with suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
        yield from entries


def _naming(path: Path, error: Exception) -> str:
    return str(error) if str(path) in str(error) else f"{path}: {error}"
