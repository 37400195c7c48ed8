"""Which stored parts were read and found sound: a cache that spares a resume reading 10^5 parts again.

A line of `<store>/checked.txt` is "<unit digest> <size> <mtime in ns> <inode> sound", of the file that held the part
when it was read. A part whose file has changed since has no line and is read again. The lines are only a cache: without
them everything is read once more. `collect` reads everything in any case, which also finds bytes that went bad beneath
an unchanged file.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

REMEMBERED_AT_ONCE = 1000  # parts found sound: a run that is killed while it reads forgets fewer than these
_LINE = re.compile(r"[0-9a-f]{64} \d+ \d+ \d+ sound")


def validate_changed(store: UnitStore, units: Iterable[Unit]) -> dict[str, str]:
    """`store.validate_all` of those parts that are not in the file in which they were last found sound."""
    known, reasons, sound = remembered(store), dict[str, str](), list[str]()
    for unit in units:
        now = stamp(store, unit.digest)
        if now is None or now in known:
            continue
        reason = store.validate(unit)
        if reason is not None:
            reasons[unit.digest] = reason
            continue
        sound.append(now)
        if len(sound) == REMEMBERED_AT_ONCE:
            remember(store, sound)
            sound.clear()
    remember(store, sound)
    return reasons


def stamp(store: UnitStore, digest: str) -> str | None:
    """The line of a part as it is stored now; None when it is not."""
    status = _status(store.path(digest))
    if status is None and (path := store.file(digest)) is not None:
        status = _status(path)
    return None if status is None else f"{digest} {status.st_size} {status.st_mtime_ns} {status.st_ino} sound"


def remembered(store: UnitStore) -> set[str]:
    """All whole lines; none when there is no such file."""
    try:
        with open(_file(store), encoding="ascii", errors="replace") as file:
            return {line.rstrip("\n") for line in file if _LINE.fullmatch(line.rstrip("\n"))}
    except OSError:
        return set()


def remember(store: UnitStore, lines: Iterable[str]) -> None:
    """Append lines. What cannot be written is not remembered, which costs a later run time and nothing else."""
    text = "".join(f"{line}\n" for line in lines)
    with suppress(OSError), open(_file(store), "a", encoding="ascii") as file:
        file.write(f"\n{text}" if text else "")  # a line that a kill cut short does not swallow the first of these


def _status(path: Path) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _file(store: UnitStore) -> Path:
    return store.folder / "checked.txt"
