"""Nodes and costs that a sampling has solved, kept on disk: one that was stopped solves none of them again.

A table of SQLite, so a process that is killed leaves what it had committed. A node's key is a digest of everything that
it depends on: problem, code, pattern, place and start. A sampling asks for equal nodes in an equal order, so that all
of an earlier one's are found.
"""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from safetensors import SafetensorError
from safetensors.numpy import load, save

from gaitflow.atlas.node import Each, Node, Place
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.core.gaits import Pattern
from gaitflow.files import make_folder
from gaitflow.runtime.atlas import Prediction
from gaitflow.runtime.starts import Start
from gaitflow.tables.solver_code import SOLVER_SOURCES, package_digest, solver_version

NODES, COSTS = ("node", "careful_node"), ("cost_at", "cost_from")  # of a `PlanSolver`; others take a tenth of the time
NODE_SOURCES = (*SOLVER_SOURCES, "atlas/node.py")
PLAN_SOURCES = {"cost_from": ("atlas/plan_solver.py",)}  # further code that a method's results depend on
PIECE = 256  # solves after which what they led to is written: looking for borders asks for thousands at once
_NUMBERS = ("slopes", "point", "tangents")


@contextmanager
def kept_nodes(path: Path, scenario: Scenario, each: Each | None) -> Iterator[Each | None]:
    """`each`, that asks the file at `path` first and adds to it what it solves; None where that is None.

    Raises ValueError when the file cannot be read or written.
    """
    if each is None:
        yield None
        return
    make_folder(path.parent)
    with closing(_Table(path)) as table:
        about = {method: _about(scenario, PLAN_SOURCES.get(method, ())) for method in (*NODES, *COSTS)}
        yield _Keeping(table, about, each)


class _Keeping:
    """Calls for those nodes only that the table does not have."""

    def __init__(self, table: _Table, about: Mapping[str, str], each: Each) -> None:
        self._table, self._about, self._each = table, about, each

    def __call__(self, method: str, calls: Sequence[tuple[Pattern, Sequence[Any]]]) -> list[Any]:
        if method not in (*NODES, *COSTS):
            return self._each(method, calls)
        keys = [self._key(method, pattern, *arguments) for pattern, arguments in calls]
        found = {key: node for key in keys if (node := self._table.read(key)) is not None}
        left = {key: call for key, call in zip(keys, calls, strict=True) if key not in found}
        asked = list(left)
        for piece in (asked[first : first + PIECE] for first in range(0, len(asked), PIECE)):
            solved = self._each(method, [left[key] for key in piece])
            fresh = {key: _bytes(result) for key, result in zip(piece, solved, strict=True)}
            self._table.add(fresh)
            found |= fresh
        if method in COSTS:
            return [self._table.cost(found[key]) for key in keys]
        return [self._table.node(found[key], place) for key, (_, (place, *_)) in zip(keys, calls, strict=True)]

    def _key(self, method: str, pattern: Pattern, place: Place, start: Prediction | Start, *further: int) -> bytes:
        about = self._about[method]
        digest = hashlib.sha256(" ".join(map(str, (about, method, pattern.text, *further))).encode())
        for numbers in (place, *_numbers_of(start)):
            digest.update(np.asarray(numbers, dtype=np.float64).tobytes())
        return digest.digest()


class _Table:
    """Contents of nodes by their keys, in a file. Raises ValueError when that cannot be read or written."""

    def __init__(self, path: Path) -> None:
        self._path = path
        with self._explained():
            self._table = sqlite3.connect(path)
            self._table.execute("CREATE TABLE IF NOT EXISTS nodes (key BLOB PRIMARY KEY, node BLOB NOT NULL)")

    def read(self, key: bytes) -> bytes | None:
        with self._explained():
            row = self._table.execute("SELECT node FROM nodes WHERE key = ?", (key,)).fetchone()
        return None if row is None else row[0]

    def add(self, nodes: Mapping[bytes, bytes]) -> None:
        with self._explained(), self._table:
            self._table.executemany("INSERT INTO nodes VALUES (?, ?)", nodes.items())

    def node(self, content: bytes, place: Place) -> Node | None:
        with self._explained():
            return _node(content, place)

    def cost(self, content: bytes) -> float | None:
        with self._explained():
            return float(load(content)["cost"][0]) if content else None

    def close(self) -> None:
        self._table.close()

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, SafetensorError, KeyError) as error:
            raise ValueError(f"{self._path}: {error}; remove it, and its nodes are solved again") from error


def _numbers_of(start: Prediction | Start) -> tuple[ArrayLike, ...]:
    if isinstance(start, Prediction):
        return [start.cost], start.point
    point = start.point
    return [start.unit, start.barrier, start.careful], point.free, point.rows, point.lower, point.upper


def _about(scenario: Scenario, further: Sequence[str]) -> str:
    """A digest of what all results of a scenario depend on, and of `further` sources."""
    space, solver = scenario.tasks.space, solver_version()
    code = solver | {"code": package_digest((*NODE_SOURCES, *further))}
    return digest_of({"problem": scenario.problem_data, "axes": [space.ranged, space.fixed], "code": code})


def _bytes(result: Node | float | None) -> bytes:
    """A node without its place, or a cost; nothing where there is no motion."""
    if result is None:
        return b""
    if isinstance(result, float):
        return save({"cost": np.array([result])})
    arrays = {name: np.ascontiguousarray(getattr(result, name), dtype=np.float64) for name in _NUMBERS}
    return save(arrays | {"cost": np.array([result.cost])})


def _node(content: bytes, place: Place) -> Node | None:
    if not content:
        return None
    arrays = load(content)
    return Node(place, float(arrays["cost"][0]), *(arrays[name] for name in _NUMBERS))
