"""Attempts at a unit that killed, hung or upset the solver: counted on disk, so that no run retries for ever."""

from __future__ import annotations

import json
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.files import publish_once
from gaitflow.search.solution import Solution
from gaitflow.store.units import Unit

MAX_ATTEMPTS = 3
DETAIL_CHARACTERS = 4000


@dataclass(frozen=True)
class LostAttempt:
    """One attempt that came to nothing: which unit, the how-manyth, why ("crashed: SIGSEGV"), when, what it said."""

    unit: str
    number: int
    reason: str
    date: str
    detail: str


class Attempts:
    """The folder `attempts/<unit digest>/<n>.json` of a run."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def record(self, unit: Unit, reason: str, detail: str = "", last: bool = False) -> int:
        """Write down one more attempt and return its number. Raises WriteError.

        After the `last` one the unit is given up, however few there were.
        """
        date = datetime.now(UTC).isoformat(timespec="seconds")
        data = {"reason": reason, "date": date, "detail": detail[-DETAIL_CHARACTERS:], "tasks": unit.as_data()["tasks"]}
        number = max(self.count(unit) + 1, MAX_ATTEMPTS if last else 1)
        while not publish_once(self.folder / unit.digest / f"{number}.json", json.dumps(data, indent=1).encode()):
            number += 1
        return number

    def count(self, unit: Unit) -> int:
        """The number of the latest attempt at this unit that came to nothing, 0 without one."""
        return _latest(self.folder / unit.digest)

    def given_up(self) -> set[str]:
        """Digests of the units with no attempt left."""
        folders = self.folder.iterdir() if self.folder.is_dir() else ()
        return {folder.name for folder in folders if _latest(folder) >= MAX_ATTEMPTS}

    def of(self, unit: Unit) -> list[LostAttempt]:
        """This unit's attempts, oldest first."""
        return sorted(map(_read, (self.folder / unit.digest).glob("*.json")), key=lambda attempt: attempt.number)

    def latest(self, number: int) -> list[LostAttempt]:
        """The latest attempts of all units, newest first."""
        files = sorted(self.folder.glob("*/*.json"), key=lambda file: file.stat().st_mtime, reverse=True)
        return [_read(file) for file in files[:number]]


def failed_solutions(unit: Unit, attempts: list[LostAttempt]) -> list[Solution]:
    """Rows that say a unit was given up: one a task, status "failed", `solver_status` such as "crashed: SIGSEGV x3"."""
    reasons = list(dict.fromkeys(attempt.reason for attempt in attempts))
    counts = {reason: sum(attempt.reason == reason for attempt in attempts) for reason in reasons}
    text = ", ".join(f"{reason} x{count}" if count > 1 else reason for reason, count in counts.items())
    scenario, strategy = unit.scenario, unit.scenario.strategy
    pattern = strategy.pattern or ""
    return [
        Solution(
            task=task,
            pattern=pattern,
            gait=gait_of(Pattern.from_text(pattern), scenario.symmetry(task)).text if pattern else "",
            strategy=strategy.name,
            start="",
            seed=unit.seeds[0] if unit.seeds else strategy.seed,
            status="failed",
            solver_status=text,
        )
        for task in unit.tasks
    ]


def _read(file: Path) -> LostAttempt:
    try:
        data: Any = json.loads(file.read_text(encoding="utf-8"))
        reason, date, detail = str(data["reason"]), str(data["date"]), str(data["detail"])
    except (OSError, ValueError, KeyError, TypeError):
        reason, date, detail = "unreadable record", "", f"{file.name} cannot be read"
    return LostAttempt(file.parent.name, _number(file), reason, date, detail)


def _latest(folder: Path) -> int:
    return max(map(_number, folder.glob("*.json")), default=0)


def _number(file: Path) -> int:
    return int(file.stem) if file.stem.isdecimal() else 0
