"""A search by Bonmin that keeps its log, also of a run that throws, hangs or is killed."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import chdir, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.search.search import Search

# Bonmin reads this file in its working directory, after the options that it was given.
OPTIONS_FILE = "bonmin.opt"
# By default Bonmin drops nodes unless they promise 1e-5 less than the incumbent: several per cent of a scaled J3. Much
# less than 1e-8, and it follows the rotations of an incumbent, which cost the same.
OPTIONS = {"bb_log_level": 3, "bb_log_interval": 1, "cutoff_decr": 1e-8}


class LoggedSearch:
    """A `Search` by Bonmin that writes the solver's log to a file, line by line; made to be called in a child."""

    def __init__(self, scenario: Mapping[str, Any], log: str) -> None:
        self._search = Search(scenario)
        self._log = Path(log).resolve()

    def __call__(self, task: Mapping[str, float], seed: int | None) -> dict[str, Any]:
        """As `Search`; the log begins anew with every call."""
        with (
            TemporaryDirectory() as folder,
            chdir(folder),
            self._log.open("w", buffering=1, encoding="utf-8") as log,
            redirect_stdout(log),
        ):
            options = "".join(f"bonmin.{name} {value}\n" for name, value in OPTIONS.items())
            Path(OPTIONS_FILE).write_text(options, encoding="utf-8")
            return self._search(task, seed)
