"""What the store and the plan cost at 10^3, 10^4, 10^5 units: planning, resuming, checking parts, compaction.

Every number is taken in a fresh process, as a resume is one. The parts are real ones of one row each, written without
waiting for the disk; their folder is below `runs`, so the file system that is measured is the one that is used.
"""

from __future__ import annotations

import io
import json
import math
import os
import resource
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NoReturn

from benchmarks.child import Child
from benchmarks.document import document
from benchmarks.infrastructure.grids import with_grid
from benchmarks.infrastructure.idle import idle_solutions
from benchmarks.rows import Row
from gaitflow.config.scenario import Scenario
from gaitflow.execute.run import run_units
from gaitflow.store.compact import compact
from gaitflow.store.known_parts import remember, stamp, validate_changed
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units
from gaitflow.tables.provenance import unit_record
from gaitflow.tables.seal import write_sealed
from gaitflow.tables.solutions import solutions_to_table

SIZES = (1_000, 10_000, 100_000)
STORED_PERCENT = 99
READ_PARTS = 1_000  # whose reading and checking is timed
LIMIT_S = 6 * 3600.0
NEXT_SIZE = 1_000_000
GROWING = (
    "plan_s", "list_s", "left_s", "decided_s", "remembered_s", "decided_rss_mb", "compact_s", "packed_decided_s",
    "packed_decided_rss_mb",
)  # fmt: skip
NOTES = (
    f"units: planned, one task each; {STORED_PERCENT} % of them stored. plan_s: scenario to units and their names. "
    "list_s: names of all stored units. left_s: plan minus list. decided_s: from the start of `run_units`, which also "
    "looks for leftovers and given-up units, to the moment that it asks for a cluster, with planning. decided_rss_mb: "
    "peak memory of that process, all imports included.",
    "validate_ms_per_part: reading a part of one row and checking its seal, unit and schema. remembered_s: the same "
    "question for all parts when checked.txt says that they were found sound: one stat a part.",
    "compact_s: all parts into packs, read back and removed; files_before, files_after: in the store's folders of "
    "units and packs. packed_*: deciding what is left from the packs.",
    "The system's caches are warm: on a shared file system the listing costs a request a few hundred names, and "
    "remembered_s a request a part unless the client caches attributes.",
)


class _Decided(Exception):
    pass


def run(scenario: Scenario, tasks: int | None = None, runs: Path = Path("runs")) -> dict[str, Any]:
    """The document: a row a size; `tasks` replaces the largest size. Works in, and empties, a folder below `runs`.

    Raises ValueError when no grid has so many tasks.
    """
    largest = tasks or SIZES[-1]
    rows = [_row(scenario, size, runs / "bench") for size in (*(size for size in SIZES if size < largest), largest)]
    summary = {f"{row['units']} units": {key: row[key] for key in rows[0] if key != "units"} for row in rows}
    notes = [*NOTES]
    if len(rows) > 1:
        told = ", ".join(f"{key} {value:.3g}" for key, value in extrapolate(rows, NEXT_SIZE).items())
        notes.append(f"{NEXT_SIZE} units, on a straight line through the two largest sizes, not measured: {told}")
    return document("store", scenario.name, rows, summary, notes)


def extrapolate(rows: Sequence[Mapping[str, Any]], size: int) -> dict[str, float]:
    """What grows with the number of units, at `size`, on the line through the last two rows."""
    before, last = rows[-2], rows[-1]
    ahead = (size - last["units"]) / (last["units"] - before["units"])
    return {key: last[key] + (last[key] - before[key]) * ahead for key in GROWING}


def planned(scenario: Scenario, size: int) -> Scenario:
    """The scenario with a grid of `size` tasks, each a unit. Raises ValueError when no grid has so many."""
    few = max(each for each in range(1, math.isqrt(size) + 1) if size % each == 0)
    spans = {"speed": (0.1, 2.0), "cycle_duration": (0.3, 1.5)}
    return with_grid(scenario, {"speed": size // few, "cycle_duration": few}, spans)


def _row(scenario: Scenario, size: int, folder: Path) -> Row:
    folder.mkdir(parents=True, exist_ok=True)
    setup = {"scenario": planned(scenario, size).as_data()}
    with tempfile.TemporaryDirectory(prefix="store-", dir=folder) as own:
        store = str(Path(own) / "run")
        _ask("fill", setup, store)
        decided, checked = _ask("decide", setup, store), _ask("check", setup, store)
        before = _files(Path(store))
        packed = _ask("pack", setup, store)
        again = _ask("decide", setup, store)
        return {
            "units": size,
            "stored": decided["stored"],
            **{key: decided[key] for key in ("plan_s", "list_s", "left_s", "decided_s", "decided_rss_mb")},
            **checked,
            **packed,
            "files_before": before,
            "files_after": _files(Path(store)),
            "packed_decided_s": again["decided_s"],
            "packed_decided_rss_mb": again["decided_rss_mb"],
        }


def _ask(operation: str, setup: Mapping[str, Any], store: str) -> dict[str, Any]:
    with Child("benchmarks.infrastructure.store:operations", setup) as child:
        answer = child.call(LIMIT_S, operation=operation, folder=store)
        assert isinstance(answer, dict)
        return answer


def operations(scenario: Mapping[str, Any]) -> Callable[[str, str], dict[str, Any]]:
    """In a child: `operation` on the store in `folder`; see `NOTES` for what it answers."""
    known = {"fill": _fill, "decide": _decide, "check": _check, "pack": _pack}
    resolved = Scenario.from_data(scenario, "bench")
    return lambda operation, folder: known[operation](resolved, UnitStore(Path(folder)))


def _fill(scenario: Scenario, store: UnitStore) -> dict[str, Any]:
    for unit in _stored(plan_units(scenario)):
        table = solutions_to_table(idle_solutions(scenario, unit.tasks), unit.scenario.as_data())
        part = io.BytesIO()
        write_sealed(part, table.schema, [table], unit_record(unit.digest, unit.as_data(), {}))
        path = store.path(unit.digest)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(part.getvalue())
    return {}


def _decide(scenario: Scenario, store: UnitStore) -> dict[str, Any]:
    def no_cluster() -> AbstractContextManager[NoReturn]:
        raise _Decided

    start = time.perf_counter()
    units = plan_units(scenario)
    digests = [unit.digest for unit in units]
    planned_at = time.perf_counter()
    try:
        run_units(units, store, no_cluster)
    except _Decided:
        decided_at = time.perf_counter()
    peak = peak_mb()
    listing = time.perf_counter()
    stored = store.solved()
    listed = time.perf_counter()
    left = [digest for digest in digests if digest not in stored]
    return {
        "stored": len(digests) - len(left),
        "plan_s": planned_at - start,
        "list_s": listed - listing,
        "left_s": time.perf_counter() - listed,
        "decided_s": decided_at - start,
        "decided_rss_mb": peak,
    }


def _check(scenario: Scenario, store: UnitStore) -> dict[str, Any]:
    units = _stored(plan_units(scenario))
    some = units[:READ_PARTS]
    start = time.perf_counter()
    damaged = store.validate_all(some)
    read = time.perf_counter() - start
    remember(store, [line for unit in units if (line := stamp(store, unit.digest)) is not None])
    start = time.perf_counter()
    damaged |= validate_changed(store, units)
    remembered = time.perf_counter() - start
    if damaged:
        raise ValueError(f"{store.folder}: parts that were just written are damaged: {json.dumps(damaged)[:400]}")
    return {"validate_ms_per_part": read / len(some) * 1e3, "remembered_s": remembered}


def _pack(scenario: Scenario, store: UnitStore) -> dict[str, Any]:
    start = time.perf_counter()
    done = compact(store)
    return {"compact_s": time.perf_counter() - start, "packs": done.packs, "packed_mb": done.bytes / 1e6}


def peak_mb() -> float:
    """Peak memory of this program. `ru_maxrss` would be at least that of the process that started it."""
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
        return int(status.partition("VmHWM:")[2].split()[0]) / 1024
    except (OSError, IndexError, ValueError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _stored(units: Sequence[Unit]) -> Sequence[Unit]:
    return units[: len(units) * STORED_PERCENT // 100]


def _files(folder: Path) -> int:
    return sum(len(names) for name in ("units", "packs") for _, _, names in os.walk(folder / name))
