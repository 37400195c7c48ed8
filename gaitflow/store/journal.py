"""A run's journal: when units of work were begun, how far they are, and when they ended.

A solver process writes one line when it begins a unit, one line of progress, which it overwrites, and one when the part
is stored or the unit ended without one. So the journal says how much time went where and which units never came to an
end; only the store says what is solved. Every solver process has a file of its own, so that lines of many machines
never mix. Its worker adds the last line when the process is gone. A worker that was killed together with its solver
leaves a begin without an end.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Event = Literal["start", "progress", "stored", "ended"]
TAIL_BYTES = 4096  # more than two lines


@dataclass(frozen=True)
class Entry:
    """One line. `time` in seconds since 1970; `solver`: the process, its id and a random word; `kept`: came first.

    Of a unit that was stored, and of one in progress: `cpu_s` with that of solves which earlier processes had done and
    which were not done again, `wall_s` since the start, the number of `solves`, and how many of them were `known` so.
    """

    event: Event
    unit: str
    time: float
    solver: str
    cpu_s: float = 0.0
    wall_s: float = 0.0
    kept: bool = False
    solves: int = 0
    known: int = 0


class Journal:
    """Appends entries to the file of one solver process below `folder` (`<store>/journal`)."""

    def __init__(self, folder: Path, solver: str) -> None:
        self.solver = solver
        self._path = folder / f"{solver}.jsonl"
        self._place: int | None = None  # where the last line begins, if it may be written over

    def started(self, unit: str) -> None:
        """A solve of this unit begins."""
        self._append(Entry("start", unit, time.time(), self.solver))

    def progress(self, unit: str, cpu_s: float, wall_s: float, solves: int, known: int) -> None:
        """The solve of this unit has come so far."""
        entry = Entry("progress", unit, time.time(), self.solver, cpu_s, wall_s, False, solves, known)
        self._place = self._append(entry)

    def stored(self, unit: str, cpu_s: float, wall_s: float, kept: bool, solves: int = 0, known: int = 0) -> None:
        """The unit was solved and a part with its digest is in the store."""
        self._append(Entry("stored", unit, time.time(), self.solver, cpu_s, wall_s, kept, solves, known))

    def ended(self, unit: str) -> None:
        """The solve of this unit is over, and nothing was stored; how far it was stays."""
        self._place = None
        self._append(Entry("ended", unit, time.time(), self.solver))

    def _append(self, entry: Entry) -> int:
        """Write a line, over one that says how far the unit was; where it begins."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with open(self._path, "ab") as file:
            if self._place is not None:
                file.truncate(self._place)
            place = file.seek(0, os.SEEK_END)
            file.write(json.dumps(entry.__dict__).encode() + b"\n")
        self._place = None
        return place


def read_journal(folder: Path) -> list[Entry]:
    """All entries of a run in the order of time; a line that a kill cut short is left out."""
    entries = []
    for file in folder.glob("*.jsonl"):
        entries += _entries(file.read_text(encoding="utf-8", errors="replace"))
    return sorted(entries, key=lambda entry: entry.time)


def unended(folder: Path) -> dict[str, list[str]]:
    """Units that were begun by solvers of which nothing was heard since, by digest: those solvers.

    A solver at work is one of them. Only the ends of the files are read, so that this can be asked at any time.
    """
    found: dict[str, list[str]] = {}
    for entry in latest(folder):
        if entry.event in ("start", "progress"):
            found.setdefault(entry.unit, []).append(entry.solver)
    return found


def latest(folder: Path) -> list[Entry]:
    """The last entry of every solver."""
    found = (_last_entry(_tail(file)) for file in folder.glob("*.jsonl"))
    return [entry for entry in found if entry is not None]


def write_off(folder: Path, unit: str, solvers: Iterable[str]) -> None:
    """Write the end of a unit into the files of solvers that are gone. Raises OSError."""
    for solver in solvers:
        Journal(folder, solver).ended(unit)


def _entries(text: str) -> list[Entry]:
    entries = map(_entry, text.splitlines())
    return [entry for entry in entries if entry is not None]


def _last_entry(text: str) -> Entry | None:
    entries = map(_entry, reversed(text.splitlines()))
    return next((entry for entry in entries if entry is not None), None)


def _entry(line: str) -> Entry | None:
    try:
        return Entry(**json.loads(line))
    except (TypeError, ValueError):
        return None


def _tail(path: Path) -> str:
    with open(path, "rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - TAIL_BYTES))
        return file.read().decode(errors="replace")
