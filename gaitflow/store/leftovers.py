"""What killed writers and given-up plans leave behind in a store."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

from gaitflow.files import TEMPORARY

LEFTOVER_AGE_S = 3600.0  # a temporary file this old belongs to a process that was killed
UNFINISHED_AGE_S = 30 * 86400.0  # a unit that nobody went on with for so long is of a plan that was given up


def remove_leftovers(store: Path) -> int:
    """Delete temporary files of writers that were killed long ago, and solves of units that nobody finished.

    `store` is the folder of a `UnitStore`. Returns the number of the files.
    """
    limit, removed = time.time() - LEFTOVER_AGE_S, 0
    for folder, _, names in os.walk(store):
        for name in names:
            if name.startswith(".") and name.endswith(TEMPORARY):
                file = Path(folder, name)
                if _modified(file) < limit:
                    file.unlink(missing_ok=True)
                    removed += 1
    for path in (store / "unfinished").glob("*"):
        if _modified(path) < time.time() - UNFINISHED_AGE_S:
            shutil.rmtree(path, ignore_errors=True)
    return removed


def _modified(file: Path) -> float:
    try:
        return file.stat().st_mtime
    except OSError:
        return float("inf")
