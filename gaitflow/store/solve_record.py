"""What was solved of a unit that is not finished: the answers of its solver, so that an interruption loses seconds.

    <store>/unfinished/<unit digest>/<solver>.solves   appended to by that solver process, removed with the stored part

A solve is named by a digest of all that determines its answer. So a unit that is begun again asks the same questions
in the same order, gets the answers that are known, bit for bit, and ends in the rows of a unit that nothing disturbed.
"""

from __future__ import annotations

import json
import time
import zlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gaitflow.core.trajectory import Array

WRITE_EVERY_S = 5.0  # what a shorter unit solved is not worth a file


@dataclass(frozen=True)
class Solved:
    """One answer: its `facts`, plain JSON data, and its arrays of float64, one-dimensional."""

    facts: Mapping[str, Any]
    arrays: tuple[Array, ...]


class SolveRecord:
    """The answers to one unit's solves: all that earlier solver processes left, and what this one, `writer`, adds.

    A record is a convenience. What cannot be read is solved again, and a disk that refuses a write loses only that.
    """

    def __init__(self, folder: Path, writer: str) -> None:
        self._path = folder / f"{writer}.solves"
        self._places: dict[str, tuple[Path, int]] = {}
        self._pending: list[bytes] = []
        self._written = time.monotonic()
        for path in sorted(folder.glob("*.solves")):
            with suppress(OSError):
                self._places |= {name: (path, place) for name, place in _index(path).items()}

    def find(self, name: str) -> Solved | None:
        """The answer that an earlier process left under this name, if any."""
        if name not in self._places:
            return None
        path, place = self._places[name]
        with suppress(OSError), open(path, "rb") as file:
            file.seek(place)
            entry = _read(file)
            if entry is not None:
                return entry[1]
        return None

    def add(self, name: str, solved: Solved) -> None:
        """Remember an answer, on disk within WRITE_EVERY_S seconds of the next one."""
        self._pending.append(_entry(name, solved))
        if time.monotonic() - self._written >= WRITE_EVERY_S:
            with suppress(OSError):
                self._path.parent.mkdir(parents=True, exist_ok=True)
                with open(self._path, "ab") as file:
                    file.write(b"".join(self._pending))
            self._pending.clear()
            self._written = time.monotonic()


def _entry(name: str, solved: Solved) -> bytes:
    """A line of a checksum and JSON, then the arrays' bytes."""
    data = b"".join(np.asarray(array, dtype="<f8").tobytes() for array in solved.arrays)
    sizes = [len(array) for array in solved.arrays]
    head = json.dumps({"name": name, "facts": dict(solved.facts), "sizes": sizes}, default=np.generic.item).encode()
    return b"%08x %s\n" % (zlib.crc32(data, zlib.crc32(head)), head) + data


def _index(path: Path) -> dict[str, int]:
    """Where each whole entry of a file begins; what a kill cut short ends it."""
    places: dict[str, int] = {}
    with open(path, "rb") as file:
        while True:
            place = file.tell()
            entry = _read(file)
            if entry is None:
                return places
            places.setdefault(entry[0], place)


def _read(file: BinaryIO) -> tuple[str, Solved] | None:
    try:
        crc, _, text = file.readline().rstrip(b"\n").partition(b" ")
        head = json.loads(text)
        sizes = [int(size) for size in head["sizes"]]
        data = file.read(8 * sum(sizes))
        if zlib.crc32(data, zlib.crc32(text)) != int(crc, 16):
            return None
        values = np.frombuffer(data, dtype="<f8")
        arrays = np.split(values, np.cumsum(sizes)[:-1])
        return str(head["name"]), Solved(head["facts"], tuple(map(np.array, arrays)))
    except (ValueError, KeyError, TypeError):
        return None
