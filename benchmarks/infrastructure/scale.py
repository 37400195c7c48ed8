"""How many workers one driver feeds: the real driver, scheduler and store under TLS, with workers that sleep.

The stand-ins (`stand_ins.py`) share this machine's cores with the driver, so what it could do alone follows from its
own CPU time a unit.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

import gaitflow.execute.count
import gaitflow.execute.run
import gaitflow.store.journal
from benchmarks.child import Child
from benchmarks.document import document
from benchmarks.infrastructure import stand_ins
from benchmarks.infrastructure.store import peak_mb, planned
from benchmarks.rows import Row, RowStore
from gaitflow.config.scenario import Scenario
from gaitflow.execute.local import local_client
from gaitflow.execute.open_files import allow_connections
from gaitflow.execute.run import run_units
from gaitflow.store.journal import Entry, read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

WORKERS = (10, 50, 100, 200, 400)
UNIT_S = (0.1, 1.0, 10.0)
SPAN_S = 25.0  # that a row is to take, by the most units a second that are to be expected here
RATE = 150.0
LEAST_UNITS = 5  # a worker
MANY = 100_000
IN_A_PROCESS = 100
STARTED_S = 300.0
LIMIT_S = 1800.0
NOTES = (
    "The workers are stand-ins: Dask workers with encrypted connections and a thread of their own, a hundred in a "
    "process, that sleep instead of solving, for 0.5 to 1.5 times unit_s; they write the journal. With stores each "
    "also stores a part durably. All run on the cores of this machine, beside the driver.",
    "ideal_per_s: workers over unit_s. per_s, busy: units a second, and the share of the workers' time in which they "
    "had a unit, from when all have begun one to when two units a worker are left to begin. efficiency: per_s over "
    "ideal_per_s; with a few units a worker it says less than busy.",
    "driver_ms: CPU time of the driver's process a unit, the scheduler in it; cpu_per_s: its inverse, what the driver "
    "could hand out with a core of its own. load: of the machine, the mean of a minute, after a row; others use it.",
    "driver_once_s, driver_ms_per_unit, driver_ms_per_worker_and_s: least squares of the driver's CPU time over all "
    "rows, by relative error; driver_fit_least, driver_fit_most: the sum over what was measured.",
    "files, driver_mb: open files and peak memory of the driver.",
)


@dataclass(frozen=True)
class Point:
    """What is measured: so many workers and units, a unit's mean seconds, and whether parts are stored."""

    workers: int
    unit_s: float
    units: int
    stores: bool = False


def run(scenario: Scenario, tasks: int = MANY, runs: Path = Path("runs")) -> dict[str, Any]:
    """The document: a row a number of workers and length of units, then the rows that `points` adds.

    `tasks` is the size of the largest plan. Works in a folder below `runs`, where only the rows stay.
    """

    def measured(key: Row) -> Row:
        point = Point(**key)
        allow_connections(point.workers)  # the child inherits it
        with tempfile.TemporaryDirectory(prefix="scale-", dir=runs / "bench") as folder:
            setup = {"scenario": scenario.as_data(), "folder": folder}
            with Child("benchmarks.infrastructure.scale:driver", setup) as child:
                return child.call(LIMIT_S, **asdict(point))

    (runs / "bench").mkdir(parents=True, exist_ok=True)
    modules = [sys.modules[__name__], stand_ins, gaitflow.execute.run, gaitflow.execute.count, gaitflow.store.journal]
    rows = RowStore("scale", scenario, runs, modules).rows([asdict(point) for point in points(tasks)], measured)
    return document("scale", None, rows, summarise(rows), NOTES)


def points(many: int) -> list[Point]:
    """A grid of workers and unit lengths, then one plan of `many` units, then units that are stored."""
    grid = [
        Point(workers, unit_s, max(LEAST_UNITS * workers, round(SPAN_S * min(workers / unit_s, RATE))))
        for unit_s in UNIT_S
        for workers in WORKERS
    ]
    return [*grid, Point(200, 0.5, many), Point(200, 2.0, 2000, stores=True)]


def summarise(rows: Sequence[Mapping[str, Any]]) -> Row:
    """The driver's CPU time as a sum of three parts, and how far each length of units kept its workers busy."""
    taken = np.array([row["driver_ms"] * row["units"] / 1e3 for row in rows])
    parts = np.array([[1.0, row["units"], row["workers"] * row["wall_s"]] for row in rows]) / taken[:, None]
    once, unit, worker = np.linalg.lstsq(parts, np.ones(len(rows)))[0]
    off = parts @ [once, unit, worker]
    return {
        "driver_once_s": once,
        "driver_ms_per_unit": 1e3 * unit,
        "driver_ms_per_worker_and_s": 1e3 * worker,
        "driver_fit_least": off.min(),
        "driver_fit_most": off.max(),
        "seen_per_s": max(row["per_s"] for row in rows),
        "workers_90_percent_busy": {
            f"{unit_s:g} s": max(
                (row["workers"] for row in rows if row["unit_s"] == unit_s and row["busy"] >= 0.9), default=None
            )
            for unit_s in UNIT_S
        },
    }


def steady(entries: Sequence[Entry], workers: int) -> tuple[float, float]:
    """Units a second and busy share of the workers, from when all have begun until two units a worker are to begin.

    Raises ValueError when there was no such time.
    """
    starts = [entry for entry in entries if entry.event == "start"]
    first = {entry.solver: entry.time for entry in reversed(starts)}
    begin, last = max(first.values()), len(starts) - 2 * workers - 1
    if len(first) < workers or last < 0 or (end := starts[last].time) <= begin:
        raise ValueError(f"{len(starts)} units are too few for {workers} workers; measure more")
    stored = [entry for entry in entries if entry.event == "stored"]
    ended = sum(begin < entry.time <= end for entry in stored)
    busy = sum(max(0.0, min(entry.time, end) - max(entry.time - entry.wall_s, begin)) for entry in stored)
    return ended / (end - begin), busy / (workers * (end - begin))


def driver(scenario: Mapping[str, Any], folder: str) -> Callable[[int, float, int, bool], Row]:
    """In a child: a run of stand-ins, and what it took."""
    resolved, store = Scenario.from_data(scenario, "bench"), UnitStore(Path(folder))

    def measure(workers: int, unit_s: float, units: int, stores: bool) -> Row:
        taken: Row = {}

        @contextmanager
        def client() -> Iterator[Any]:
            with local_client(0) as opened, _stand_ins(opened, workers, unit_s, stores):
                _wait_for(opened, workers)
                cpu, begin = time.process_time(), time.monotonic()
                yield opened
                taken["wall_s"] = time.monotonic() - begin
                taken["driver_ms"] = (time.process_time() - cpu) / units * 1e3
                taken["files"] = len(os.listdir("/proc/self/fd"))

        planned_units = plan_units(planned(resolved, units))
        begin = time.monotonic()
        state = run_units(planned_units, store, client)
        taken["all_s"] = time.monotonic() - begin
        if state.left or (stores and len(store.solved()) != units):
            raise ValueError(f"{store.folder}: of {units} units {state.left} are left, {len(store.solved())} stored")
        per_s, busy = steady(read_journal(store.folder / "journal"), workers)
        return {
            "ideal_per_s": workers / unit_s,
            "per_s": per_s,
            "efficiency": per_s * unit_s / workers,
            "busy": busy,
            **taken,
            "cpu_per_s": 1e3 / taken["driver_ms"],
            "driver_mb": peak_mb(),
            "load": os.getloadavg()[0],
        }

    return measure


def _wait_for(client: Any, workers: int) -> None:
    # Dask's own wait asks for all that is known of all workers, ten times a second.
    deadline = time.monotonic() + STARTED_S
    while (joined := len(client.nthreads())) < workers:
        if time.monotonic() > deadline:
            raise TimeoutError(f"{joined} of {workers} stand-ins joined within {STARTED_S:.0f} s; start fewer")
        time.sleep(1.0)


@contextmanager
def _stand_ins(client: Any, workers: int, unit_s: float, stores: bool) -> Iterator[None]:
    command = [sys.executable, "-m", "benchmarks.infrastructure.stand_ins", "--parent", str(os.getpid())]
    command += ["--scheduler", client.cluster.scheduler_address, "--unit-s", str(unit_s)]
    command += ["--certificate", client.security.tls_worker_cert, "--key", client.security.tls_worker_key]
    with ExitStack() as stack:
        for first in range(0, workers, IN_A_PROCESS):
            number = ["--workers", str(min(IN_A_PROCESS, workers - first))]
            stack.enter_context(_ended(subprocess.Popen([*command, *number, *(["--store"] if stores else [])])))
        yield


@contextmanager
def _ended(process: subprocess.Popen[bytes]) -> Iterator[None]:
    try:
        yield
    finally:
        process.kill()
        process.wait()
