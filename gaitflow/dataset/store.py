"""The durable store of solved units: the truth about what is done. Whatever moves work may die at any moment.

    <folder>/units/<first 2 digits>/<unit digest>.parquet   one complete, sealed part a unit
    <folder>/attempts/<unit digest>/<n>.json                attempts that killed the solver
    <folder>/quarantine/                                    parts that were damaged or foreign, each with its reason

A part is never changed: the first complete file wins.
"""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from gaitflow.dataset import seal
from gaitflow.dataset.attempts import Attempts
from gaitflow.dataset.provenance import KEY, read_record, unit_record
from gaitflow.dataset.schema import Sizes, schema_difference, solution_schema, solutions_to_table
from gaitflow.dataset.tasks import Task
from gaitflow.dataset.units import Unit
from gaitflow.files import TEMPORARY, atomic_write, new_file
from gaitflow.scenario import digest_of
from gaitflow.solve.solution import Solution

MAX_PART_BYTES = 4 << 30  # of one file, and of its columns when unpacked
LEFTOVER_AGE_S = 3600.0  # a temporary file this old belongs to a process that was killed
_PART = re.compile(r"[0-9a-f]{64}\.parquet")


class DamagedPart(ValueError):
    """A stored part that cannot be trusted; the message names the file and what is wrong with it."""


class UnitStore:
    """The parts of one run, below `folder` (`runs/<scenario>`). Many processes may use one store at once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.attempts = Attempts(folder / "attempts")

    def path(self, digest: str) -> Path:
        """Where the part of a unit is, or will be."""
        return self.folder / "units" / digest[:2] / f"{digest}.parquet"

    def has(self, unit: Unit) -> bool:
        """Whether the unit is solved, or was given up."""
        return self.path(unit.digest).is_file()

    def solved(self) -> frozenset[str]:
        """Digests of all stored units, from one listing."""
        found: set[str] = set()
        root = self.folder / "units"
        for shelf in os.scandir(root) if root.is_dir() else ():
            if shelf.is_dir():
                found.update(entry.name[:64] for entry in os.scandir(shelf.path) if _PART.fullmatch(entry.name))
        return frozenset(found)

    def write(self, unit: Unit, solutions: Sequence[Solution], solver_options: Mapping[str, Any]) -> bool:
        """Store a unit's solutions durably: False when another process had stored the unit before.

        Raises WriteError when the disk refuses, ValueError when an array has not the scenario's shape or when the
        solutions are not those of the unit's tasks.
        """
        given = {Task(row.speed, row.cycle_duration, row.split) for row in solutions}
        if given != set(unit.tasks):
            odd = sorted(given ^ set(unit.tasks))
            raise ValueError(f"the solver's rows and the unit's tasks differ, for one in {odd[0]}")
        table = solutions_to_table(solutions, Sizes.of(unit.scenario))
        try:
            with new_file(self.path(unit.digest), replace=False) as file:
                write_sealed(file, table.schema, [table], unit_record(unit, solver_options))
        except FileExistsError:
            return False
        return True

    def read(self, unit: Unit, columns: Sequence[str] | None = None) -> pa.Table:
        """A unit's rows, checked whole: seal, schema, and that it is this unit's. Raises DamagedPart."""
        path = self.path(unit.digest)
        try:
            if path.stat().st_size > MAX_PART_BYTES:
                raise DamagedPart(f"{path}: {path.stat().st_size} bytes; a part has at most {MAX_PART_BYTES}")
            seal.check_seal(path)
            with pq.ParquetFile(path) as file:
                self._check(unit, file, path)
                return file.read(columns=None if columns is None else list(columns))
        except FileNotFoundError:
            raise DamagedPart(f"{path}: missing; run the solve again") from None
        except DamagedPart:
            raise
        except (seal.BrokenSeal, pa.ArrowException, OSError, ValueError) as error:
            text = str(error) if str(path) in str(error) else f"{path}: {error}"
            raise DamagedPart(text) from None

    def validate(self, unit: Unit) -> str | None:
        """None when the unit's part is sound or absent; otherwise move it to quarantine and return the reason."""
        if not self.has(unit):
            return None
        try:
            self.read(unit, columns=["status"])
        except DamagedPart as error:
            self._quarantine(unit, str(error))
            return str(error)
        return None

    def validate_all(self, units: Iterable[Unit]) -> dict[str, str]:
        """Check every stored part of `units`: the digests that went to quarantine, with the reason each."""
        reasons = ((unit.digest, self.validate(unit)) for unit in units)
        return {digest: reason for digest, reason in reasons if reason is not None}

    def remove_leftovers(self) -> int:
        """Delete temporary files of writers that were killed long ago; how many there were."""
        limit = time.time() - LEFTOVER_AGE_S
        old = [file for file in self.folder.rglob(f".*{TEMPORARY}") if _modified(file) < limit]
        for file in old:
            file.unlink(missing_ok=True)
        return len(old)

    def _check(self, unit: Unit, file: pq.ParquetFile, path: Path) -> None:
        groups = (file.metadata.row_group(i).total_byte_size for i in range(file.metadata.num_row_groups))
        if sum(groups) > MAX_PART_BYTES:
            raise DamagedPart(f"{path}: unpacks to more than {MAX_PART_BYTES} bytes")
        record = read_record(file.metadata.metadata, str(path))
        name = record.get("unit_digest")
        if name != unit.digest or digest_of(record.get("unit")) != unit.digest:
            raise DamagedPart(f"{path}: foreign: it holds the unit {name}, not the one it is named after")
        difference = schema_difference(file.schema_arrow, solution_schema(Sizes.of(unit.scenario)))
        if difference:
            raise DamagedPart(f"{path}: foreign: {difference}")

    def _quarantine(self, unit: Unit, reason: str) -> None:
        folder = self.folder / "quarantine"
        folder.mkdir(parents=True, exist_ok=True)
        stem = f"{unit.digest}-{time.time_ns()}"
        try:
            os.rename(self.path(unit.digest), folder / f"{stem}.parquet")
        except FileNotFoundError:
            return  # another process was quicker
        atomic_write(folder / f"{stem}.txt", f"{reason}\n".encode())


def write_sealed(file: BinaryIO, schema: pa.Schema, tables: Iterable[pa.Table], record: Mapping[str, Any]) -> None:
    """Write tables of one schema as one sealed Parquet file with its record (zstd, page checksums)."""
    writer = pq.ParquetWriter(file, schema, compression="zstd", write_page_checksum=True)
    with writer:
        for table in tables:
            writer.write_table(table)
        writer.add_key_value_metadata({KEY.decode(): json.dumps(record, sort_keys=True), seal.KEY: seal.BLANK})
    seal.seal(file)


def _modified(file: Path) -> float:
    try:
        return file.stat().st_mtime
    except OSError:
        return float("inf")
