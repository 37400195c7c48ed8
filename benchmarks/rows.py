"""Rows of a long bench, each kept on disk as soon as it is measured, so that a bench that was stopped goes on.

A row's file is named by all that the row depends on: its key, the problem, the search settings, the code that solves
and that measures, and the machine. Whatever changes one of them measures anew; nothing else does.
"""

from __future__ import annotations

import inspect
import json
import sys
import textwrap
import time
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import ModuleType
from typing import Any

from benchmarks.document import machine, plain
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.files import atomic_write
from gaitflow.tables.solver_code import solver_version, source_digest

Row = dict[str, Any]


class RowStore:
    """Measured rows of one bench on one scenario, in `<runs>/bench/<bench>-<scenario>-<digest>/<row digest>.json`.

    `measuring` are the modules whose code decides what a row holds, `about` whatever else does (plain JSON data).
    `solving` says which settings and code of the search do, by default all of them: a row that takes hours and depends
    on less should not be measured anew for the rest.
    """

    def __init__(
        self,
        bench: str,
        scenario: Scenario,
        runs: Path,
        measuring: Sequence[ModuleType],
        about: Mapping[str, Any] | None = None,
        solving: Mapping[str, Any] | None = None,
    ) -> None:
        strategy = scenario.strategy.model_dump(mode="json", exclude={"tasks_per_unit"})
        self._base = plain(
            {
                "problem": scenario.problem_digest,
                **(solving or {"strategy": strategy, "solver": solver_version()}),
                "measuring": source_digest({module.__name__: _source(module) for module in measuring}),
                "machine": machine(),
                "about": about or {},
            }
        )
        self.folder = runs / "bench" / f"{bench}-{scenario.name}-{digest_of(self._base)[:12]}"
        self._title = f"{bench} {scenario.name}"

    def path(self, key: Mapping[str, Any]) -> Path:
        """Where the row of a key is, or will be."""
        return self.folder / f"{digest_of(self._base | {'key': plain(key)})}.json"

    def rows(self, keys: Sequence[Mapping[str, Any]], measure: Callable[[Row], Mapping[str, Any]]) -> list[Row]:
        """A row a key, in order: the key's fields and what `measure(key)` says; only what is missing is measured.

        Says on standard error how far it is. Raises WriteError when a row cannot be kept.
        """
        found = [self._read(key) for key in keys]
        missing = [index for index, row in enumerate(found) if row is None]
        start = time.monotonic()
        for done, index in enumerate(missing):
            left = f", {_span((time.monotonic() - start) / done * (len(missing) - done))} to go" if done else ""
            _say(f"{self._title}: {len(keys) - len(missing) + done} of {len(keys)} rows{left}")
            key = dict(keys[index])
            found[index] = key | plain(measure(key)) | {"measured": datetime.now(UTC).isoformat(timespec="seconds")}
            atomic_write(self.path(key), (json.dumps({"key": plain(key), "row": found[index]}) + "\n").encode())
        if missing:
            _say(f"{self._title}: {len(keys)} rows in {_span(time.monotonic() - start)}")
        return [row for row in found if row is not None]

    def _read(self, key: Mapping[str, Any]) -> Row | None:
        path = self.path(key)
        try:
            stored = json.loads(path.read_bytes())
            if stored["key"] == plain(key) and isinstance(stored["row"], dict):
                return stored["row"]
            fault = "it is of another row"
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as error:
            fault = str(error) or type(error).__name__
        _say(f"{path}: cannot be used ({fault}); the row is measured again")
        return None


def _source(module: ModuleType) -> str:
    return textwrap.dedent(inspect.getsource(module))


def _span(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
