"""A run's journal: one line when a solve of a unit starts and one when its part is stored.

It tells how much time went where; what is solved only the store knows. Every solver process appends to a file of its
own, so that lines of many machines never mix.
"""

from __future__ import annotations

import json
import os
import secrets
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Event = Literal["start", "stored"]


@dataclass(frozen=True)
class Entry:
    """One line. `time` in seconds since 1970; `solver`: the process, its id and a random word; `kept`: came first.

    `cpu_s` and `wall_s` are those of the whole unit, 0 at its start.
    """

    event: Event
    unit: str
    time: float
    solver: str
    cpu_s: float = 0.0
    wall_s: float = 0.0
    kept: bool = False


class Journal:
    """Appends entries to a new file below `folder` (`<store>/journal`)."""

    def __init__(self, folder: Path) -> None:
        self._solver = f"{os.getpid()}-{secrets.token_hex(4)}"
        self._path = folder / f"{self._solver}.jsonl"

    def started(self, unit: str) -> None:
        """A solve of this unit begins."""
        self._append(Entry("start", unit, time.time(), self._solver))

    def stored(self, unit: str, cpu_s: float, wall_s: float, kept: bool) -> None:
        """The unit was solved and a part with its digest is in the store."""
        self._append(Entry("stored", unit, time.time(), self._solver, cpu_s, wall_s, kept))

    def _append(self, entry: Entry) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with open(self._path, "a", encoding="utf-8") as file:
            file.write(json.dumps(entry.__dict__) + "\n")


def read_journal(folder: Path) -> list[Entry]:
    """All entries of a run in the order of time; a line that a kill cut short is left out."""
    entries = []
    for file in folder.glob("*.jsonl"):
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            try:
                entries.append(Entry(**json.loads(line)))
            except (TypeError, ValueError):
                continue
    return sorted(entries, key=lambda entry: entry.time)
