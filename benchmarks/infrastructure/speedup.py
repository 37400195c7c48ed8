"""Two workers against one on the same real units: wall time, CPU time, and where the rest goes.

On worker processes of this machine, or with a profile on the jobs of a cluster.
"""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.document import document
from benchmarks.infrastructure.grids import with_grid
from benchmarks.rows import Row
from gaitflow.config.cluster import Profile
from gaitflow.config.scenario import Scenario
from gaitflow.execute.local import local_client
from gaitflow.execute.run import run_units
from gaitflow.execute.solver import longest_unit_s
from gaitflow.execute.solver_process import SOLVE
from gaitflow.store.journal import Entry, read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

WORKERS = (1, 2, 1)  # the runs with one are before and after, since a machine's speed drifts within minutes
TASKS = 72  # one a unit, in the plane some 3.5 s each: the longer the units, the longer a worker idles at the end
DURATIONS = 4
STARTED_S = 600.0  # within which the workers have to be there
NOTES = (
    "The same units, a task each, in random order, by one worker, by two, by one again; each run has its own "
    "store. span_s: from the start of the first unit, with all workers connected, to when the last part was stored.",
    "speedup: span with one worker, the mean of both runs, over span with two; speedup_least and _most: by either of "
    "them; efficiency: speedup over two. cpu_ratio: CPU time with two over mean CPU time with one, above 1 where the "
    "cores get in each other's way or are shared. busy: the share of workers x span in which a unit was in work; the "
    "rest is overhead and the idle worker at the end.",
)


def run(
    scenario: Scenario,
    tasks: int = TASKS,
    profile: Profile | None = None,
    runs: Path = Path("runs"),
    solve: str = SOLVE,
) -> dict[str, Any]:
    """The document: a row a run. Works in, and empties, a folder below `runs`, which nodes must share.

    `tasks` of the scenario's grid are solved, spread over it, one a unit. Raises what `cluster_client` does.
    """
    units = plan_units(spread(scenario, tasks))
    (runs / "bench").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="speedup-", dir=runs / "bench") as folder:
        rows = [
            _row(units, UnitStore(Path(folder) / f"run-{i}"), each, profile, solve) for i, each in enumerate(WORKERS)
        ]
    name = "speedup" if profile is None else f"speedup-{profile.scheduler}"
    return document(name, scenario.name, rows, summarise(rows), NOTES)


def spread(scenario: Scenario, tasks: int) -> Scenario:
    """The scenario on a grid of about `tasks` tasks over the same rectangle, one a unit."""
    ranges = scenario.tasks.ranges
    durations = min(DURATIONS, ranges["cycle_duration"].count) if "cycle_duration" in ranges else 1
    return with_grid(scenario, {"cycle_duration": durations, "speed": max(2, round(tasks / durations))})


def measured(entries: Sequence[Entry], workers: int) -> Row:
    """One run, from its journal."""
    stored = [entry for entry in entries if entry.event == "stored"]
    span = max(entry.time for entry in stored) - min(entry.time for entry in entries if entry.event == "start")
    walls = [entry.wall_s for entry in stored]
    return {
        "workers": workers,
        "units": len(stored),
        "span_s": span,
        "cpu_s": sum(entry.cpu_s for entry in stored),
        "unit_wall_s_median": statistics.median(walls),
        "unit_wall_s_max": max(walls),
        "unit_cpu_s_median": statistics.median(entry.cpu_s for entry in stored),
        "busy": sum(walls) / (workers * span),
    }


def summarise(rows: Sequence[Row]) -> Row:
    """Speed-up and efficiency of the run with most workers over those with one, and what explains them."""
    more = max(rows, key=lambda row: row["workers"])
    ones = [row for row in rows if row["workers"] == 1]
    mean = {
        key: statistics.fmean(one[key] for one in ones) for key in ("span_s", "cpu_s", "busy", "unit_wall_s_median")
    }
    speedups = [one["span_s"] / more["span_s"] for one in ones]
    return {
        "units": more["units"],
        "workers": more["workers"],
        "speedup": mean["span_s"] / more["span_s"],
        "speedup_least": min(speedups),
        "speedup_most": max(speedups),
        "efficiency": mean["span_s"] / more["span_s"] / more["workers"],
        "cpu_ratio": more["cpu_s"] / mean["cpu_s"] if mean["cpu_s"] else None,
        "busy_one": mean["busy"],
        "busy": more["busy"],
        "unit_wall_s_median": mean["unit_wall_s_median"],
    }


def _row(units: Sequence[Unit], store: UnitStore, workers: int, profile: Profile | None, solve: str) -> Row:
    @contextmanager
    def client() -> Iterator[Any]:
        if profile is None:
            opened = local_client(workers)
        else:
            from gaitflow.execute.schedulers.cluster_client import cluster_client  # dask-jobqueue is only needed here

            pool = profile.model_copy(update={"jobs": workers})
            opened = cluster_client(pool, store.folder, longest_unit_s(units))
        with opened as each:
            each.wait_for_workers(workers, timeout=STARTED_S)
            yield each

    run_units(units, store, client, solve=solve)
    return measured(read_journal(store.folder / "journal"), workers)
