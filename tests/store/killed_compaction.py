"""Compaction that is killed at its n-th step in the store: `killed_compaction.py STORE N`; exit code 9 when it was.

Steps are what Python tells its audit hooks, a moment before it is done: a file opened, removed, renamed, a folder made.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from gaitflow.store.compact import compact
from gaitflow.store.parts import UnitStore

KILLED = 9


def main() -> None:
    folder, fatal = sys.argv[1], int(sys.argv[2])
    step = 0

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        nonlocal step
        if event in ("open", "os.remove", "os.rename", "os.link", "os.mkdir") and str(arguments[0]).startswith(folder):
            step += 1
            if step == fatal:
                os._exit(KILLED)

    sys.addaudithook(hook)
    compact(UnitStore(Path(folder)))


if __name__ == "__main__":
    main()
