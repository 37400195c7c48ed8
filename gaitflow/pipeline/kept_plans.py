"""Plans of a certificate, kept on disk: one that was stopped makes none of them again.

A file of lines of JSON: a digest of what all plans depend on, then a plan each, in the order in which they are made.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from gaitflow.config.scenario import digest_of
from gaitflow.execute.map_processes import Asked, Planned
from gaitflow.files import atomic_write
from gaitflow.runtime.manifest import Manifest
from gaitflow.tables.solver_code import SOLVER_SOURCES, package_digest, solver_version

PLAN_SOURCES = (*SOLVER_SOURCES, "runtime/*.py")


class KeptPlans:
    """The `plans` so far, to which others are added."""

    def __init__(self, plans: Sequence[Planned], file: TextIO) -> None:
        self.plans, self._before, self._file = list(plans), len(plans), file

    def add(self, plan: Planned) -> int:
        """Keep one more plan; returns how many were added."""
        self.plans.append(plan)
        self._file.write(json.dumps(plan) + "\n")
        self._file.flush()
        return len(self.plans) - self._before


@contextmanager
def kept_plans(path: Path, manifest: Manifest, asked: Sequence[Asked]) -> Iterator[KeptPlans]:
    """What the file at `path` has of the plans that the map of a manifest is asked for: the first ones of all.

    Plans of another version of a map, by other code or for other tasks are dropped.
    """
    head = json.dumps(_about(manifest, asked))
    plans = _read(path, head)
    atomic_write(path, "".join(f"{line}\n" for line in (head, *map(json.dumps, plans))).encode())
    with path.open("a", encoding="utf-8") as file:
        yield KeptPlans(plans, file)


def _read(path: Path, head: str) -> list[Planned]:
    """The plans below a head, up to a line that is not whole."""
    lines = path.read_bytes().split(b"\n") if path.exists() else []
    plans: list[Planned] = []
    if lines and lines[0] == head.encode():
        with suppress(ValueError):  # of a damaged line
            for line in lines[1:-1]:  # a whole line ends, so nothing is after the last end
                gait, cost = json.loads(line)
                plans.append((gait, cost))
    return plans


def _about(manifest: Manifest, asked: Sequence[Asked]) -> str:
    """A digest of the map, the code that plans, and what is asked for."""
    files = {name: entry.sha256 for name, entry in manifest.files.items()}
    code = solver_version() | {"code": package_digest(PLAN_SOURCES)}
    return digest_of({"scenario": manifest.scenario_digest, "files": files, "code": code, "asked": asked})
