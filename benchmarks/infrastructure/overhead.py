"""What moving the work costs: scheduler overhead per unit, start-up to the first solve, what a worker imports.

The units are idle ones (`idle.py`), stored as real ones are, on worker processes of this machine.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.document import document
from benchmarks.infrastructure.idle import loaded
from benchmarks.infrastructure.store import planned
from benchmarks.rows import Row
from gaitflow.config.scenario import Scenario
from gaitflow.execute.local import local_client
from gaitflow.execute.run import run_units
from gaitflow.execute.solver import Solver
from gaitflow.store.journal import Entry, read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

IDLE = "benchmarks.infrastructure.idle:"
SLEEPS = {"no_time": 0.0, "one_second": 1.0}  # solver: seconds of a solve
WORKERS = (1, 2)
TASKS = 400  # units of no time; of one second a tenth
TYPICAL_UNIT_S = 10.0
STARTS = 5
NOTES = (
    "overhead_ms_per_unit: from one part stored to the next one stored by the same solver process, less the sleep; the "
    "mean. Handing out, storing durably and reporting are in it, planning and start-up are not.",
    f"overhead_share: the overhead at one-second units over units of {TYPICAL_UNIT_S:.0f} s.",
    "first_solve_s: from the call of a run to its first unit being worked on, the worker processes and their solver "
    "processes started, everything imported. solver_start_s: the same for one solver process alone, until its first "
    "receipt; later_unit_s: until the next one's.",
    "worker_imports, solver_imports: which heavy packages the two processes have loaded in the end.",
)


def run(scenario: Scenario, tasks: int = TASKS, runs: Path = Path("runs")) -> dict[str, Any]:
    """The document: a row a kind of unit and number of workers. Works in, and empties, a folder below `runs`."""
    (runs / "bench").mkdir(parents=True, exist_ok=True)
    rows, imports = [], dict[str, list[str]]()
    with tempfile.TemporaryDirectory(prefix="overhead-", dir=runs / "bench") as folder:
        for name, sleep in SLEEPS.items():
            units = plan_units(planned(scenario, max(2, tasks // 10) if sleep else tasks))
            for workers in WORKERS:
                store = UnitStore(Path(folder) / f"{name}-{workers}")
                rows.append(_row(units, store, name, workers, imports))
        starts = [_start(Path(folder) / f"start-{i}", units) for i in range(STARTS)]
    return document("overhead", scenario.name, rows, summarise(rows, starts) | imports, NOTES)


def summarise(rows: Sequence[Row], starts: Sequence[tuple[float, float]]) -> Row:
    """The overhead of each kind of unit on the most workers, its share of a typical unit, medians of the starts."""
    most = max(row["workers"] for row in rows)
    per_unit = {row["solver"]: row["overhead_ms_per_unit"] for row in rows if row["workers"] == most}
    first, later = (sorted(column)[len(starts) // 2] for column in zip(*starts, strict=True))
    return {
        "workers": most,
        **{f"overhead_ms_{solver}": value for solver, value in per_unit.items()},
        "overhead_share": per_unit["one_second"] / 1e3 / TYPICAL_UNIT_S,
        "first_solve_s": sorted(row["first_solve_s"] for row in rows)[len(rows) // 2],
        "solver_start_s": first,
        "later_unit_s": later,
    }


def _row(units: Sequence[Unit], store: UnitStore, name: str, workers: int, imports: dict[str, list[str]]) -> Row:
    @contextmanager
    def client() -> Iterator[Any]:
        with local_client(workers) as opened:
            yield opened
            imports["worker_imports"] = sorted({name for names in opened.run(loaded).values() for name in names})

    start = time.time()
    run_units(units, store, client, solve=IDLE + name)
    wall = time.time() - start
    entries = read_journal(store.folder / "journal")
    first = min(entry.time for entry in entries if entry.event == "start")
    statuses = {text for unit in units for text in store.read(unit, ["solver_status"])["solver_status"].to_pylist()}
    imports["solver_imports"] = sorted({name for text in statuses for name in text.split(",")})
    return {
        "solver": name,
        "sleep_s": SLEEPS[name],
        "workers": workers,
        "units": len(units),
        "wall_s": wall,
        "first_solve_s": first - start,
        "overhead_ms_per_unit": (cycle_s(entries) - SLEEPS[name]) * 1e3,
    }


def cycle_s(entries: Sequence[Entry]) -> float:
    """Mean seconds from one stored part to the next of the same solver process. Raises ValueError for single ones."""
    ends: dict[str, list[float]] = {}
    for entry in entries:
        if entry.event == "stored":
            ends.setdefault(entry.solver, []).append(entry.time)
    cycles = sum(len(times) - 1 for times in ends.values())
    if not cycles:
        raise ValueError("no solver process stored two units; measure more tasks")
    return sum(max(times) - min(times) for times in ends.values()) / cycles


def _start(folder: Path, units: Sequence[Unit]) -> tuple[float, float]:
    """Seconds until a new solver process answers its first unit, and from there its second."""
    solver, store = Solver(f"{IDLE}no_time"), UnitStore(folder)
    try:
        start = time.perf_counter()
        solver.run(units[0], store)
        first = time.perf_counter()
        solver.run(units[1], store)
        return first - start, time.perf_counter() - first
    finally:
        solver.close()
