"""kill -9 at random moments: does the dataset come out the same, and is no solved unit solved again?

`python -m benchmarks.infrastructure.faults` solves a small scenario undisturbed, then again and again while it
kills, in turn, a random Dask worker or the whole run, and starts a killed run anew. Whether a unit was repeated is
judged from outside, by the journal's starts against the time of the stored file, not by the code under test. Linux
only (/proc).
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from benchmarks.infrastructure.grids import with_grid
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.dataset.collect import collect
from gaitflow.dataset.read import load_solutions
from gaitflow.execute.local import local_client
from gaitflow.execute.run import run_units
from gaitflow.store.journal import Entry, read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units
from gaitflow.tables.provenance import made_by
from gaitflow.tables.schema import task_columns

Fault = Literal["worker", "run"]
QUIET_S = (0.5, 6.0)
POLL_S = 0.05
ORPHAN_GRACE_S = 20.0  # a solver cannot leave a call of CasADi, which builds fine meshes in some seconds
ENDS_WITHIN_S = 600.0
DRIVE = "from benchmarks.infrastructure.faults import drive; drive()"


@dataclass(frozen=True)
class Kill:
    """One kill: when (seconds since 1970), the solver processes it took along, and how many outlived a killed run."""

    fault: Fault
    time: float
    solvers: frozenset[int]
    orphans: int

    def lost(self, each: Round) -> int:
        """Units in work in those processes whose parts were not stored yet."""
        started = {e.unit for e in each.journal if e.event == "start" and _pid(e) in self.solvers}
        return sum(each.stored.get(unit, float("inf")) > self.time for unit in started)

    def recovered(self, each: Round) -> float | None:
        """Seconds until a solver process that is new starts a unit; None when the run ended without needing one."""
        before = {e.solver for e in each.journal if e.time <= self.time}
        later = [e.time - self.time for e in each.journal if e.time > self.time and e.solver not in before]
        return min(later, default=None)


@dataclass(frozen=True, eq=False)
class Round:
    """One disturbed run to its end: its kills, its journal, when each part was stored, and its dataset."""

    kills: tuple[Kill, ...]
    journal: tuple[Entry, ...]
    stored: dict[str, float]
    frame: pd.DataFrame | None  # None when it did not end


def faults(
    scenario: Scenario, tasks: int = 12, kills: int = 20, seed: int = 0, quiet_s: tuple[float, float] = QUIET_S
) -> dict[str, Any]:
    """The benchmark's document. `scenario` is cut to about `tasks` grid tasks over its range, one a unit.

    The time from one kill to the next, with a solver at work, is drawn uniformly from `quiet_s`.
    """
    counts = {"cycle_duration": 2, "speed": max(2, tasks // 2)}
    small, chance = with_grid(scenario, counts), random.Random(seed)
    pending: list[Fault] = [("worker", "run")[i % 2] for i in range(kills)]
    rounds: list[Round] = []
    with tempfile.TemporaryDirectory() as folder:
        reference = _round(small, Path(folder, "undisturbed"), [], chance, quiet_s).frame
        assert reference is not None, "the undisturbed run did not end"
        while pending:
            rounds.append(_round(small, Path(folder, f"round-{len(rounds)}"), pending, chance, quiet_s))
            done = sum(len(each.kills) for each in rounds)
            print(f"{done} of {kills} kills in {len(rounds)} round(s)", file=sys.stderr, flush=True)
    differences = [_difference(reference, each.frame) for each in rounds]
    equal = [difference for difference in differences if difference is not None]
    rows = [_row(fault, rounds, differences) for fault in ("worker", "run")]
    machine = made_by()
    return {
        "bench": "faults",
        "scenario": scenario.name,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": {"cpu": machine["cpu"], "cores": os.cpu_count(), "system": machine["system"]},
        "versions": {"gaitflow": machine["code"], "python": machine["python"], **machine["packages"]},
        "rows": rows,
        "summary": {
            "kills": sum(row["kills"] for row in rows),
            "ended": sum(row["ended"] for row in rows),
            "repeated": sum(row["repeated"] for row in rows),
            "lost_in_flight": sum(row["lost_in_flight"] for row in rows),
            "orphans": sum(kill.orphans for each in rounds for kill in each.kills),
            "rounds": len(rounds),
            "units": len(plan_units(small)),
            "solutions": len(reference),
            "cost_difference_max_rel": max(equal) if len(equal) == len(rounds) else None,
        },
    }


def drive() -> None:
    """The run that gets killed: a program of its own, `SCENARIO.json STORE` its arguments."""
    file, folder = sys.argv[1:3]
    scenario = Scenario.from_data(json.loads(Path(file).read_text(encoding="utf-8")), file)
    run_units(plan_units(scenario), UnitStore(Path(folder)), local_client)


def _round(
    scenario: Scenario, folder: Path, pending: list[Fault], chance: random.Random, quiet_s: tuple[float, float]
) -> Round:
    """Run to the end under kills taken from the end of `pending`; what the run does not live to see stays there."""
    folder.mkdir()
    file = folder / "scenario.json"
    file.write_text(json.dumps(scenario.as_data()), encoding="utf-8")
    store, kills, deadline = UnitStore(folder / "run"), list[Kill](), time.monotonic() + ENDS_WITHIN_S
    code: int | None = -signal.SIGKILL
    while code == -signal.SIGKILL and time.monotonic() < deadline:
        with _driven(file, store.folder) as run:
            while run.poll() is None and time.monotonic() < deadline:
                if not pending:
                    _wait(run, deadline - time.monotonic())
                    continue
                # Counted from when there is something to disturb, not from an interpreter's start.
                if _in_work(run.pid) and not _wait(run, chance.uniform(*quiet_s)):
                    kill = _kill(run, pending[-1], chance)
                    if kill is not None:
                        kills.append(kill)
                        pending.pop()
                time.sleep(POLL_S)
            code = run.poll()
    stored = {digest: store.path(digest).stat().st_mtime for digest in store.solved()}
    frame = load_solutions(collect(store, scenario)).frame() if code == 0 else None
    return Round(tuple(kills), tuple(read_journal(store.folder / "journal")), stored, frame)


@contextmanager
def _driven(file: Path, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    with open(file.with_suffix(".log"), "ab") as log:
        run = subprocess.Popen([sys.executable, "-c", DRIVE, str(file), str(folder)], stdout=log, stderr=log)
    try:
        yield run
    finally:
        run.kill()
        run.wait()


def _kill(run: subprocess.Popen[bytes], fault: Fault, chance: random.Random) -> Kill | None:
    """Kill now; None when there was nothing to kill, as the run was ending or starting a worker."""
    everyone, workers = _descendants(run.pid), _workers(run.pid)
    if not workers or run.poll() is not None:
        return None
    victim = chance.choice(workers) if fault == "worker" else run.pid
    solvers = frozenset(_descendants(victim))
    now = time.time()
    os.kill(victim, signal.SIGKILL)
    orphans = 0
    if fault == "run":
        run.wait()
        deadline = time.monotonic() + ORPHAN_GRACE_S
        while (orphans := sum(map(_alive, everyone))) and time.monotonic() < deadline:
            time.sleep(POLL_S)
    return Kill(fault, now, solvers, orphans)


def _row(fault: Fault, rounds: Sequence[Round], differences: Sequence[float | None]) -> dict[str, Any]:
    """One kind of kill: how many there were, and of what came after them.

    `ended`: kills in rounds that ended with the undisturbed dataset. `repeated`: starts of a unit after its part was
    stored, up to the next kill. `lost_in_flight`: units in work that had to be started again. `recovered_s`: median
    seconds until a new solver process was at work.
    """
    mine = [(each, i, kill) for each in rounds for i, kill in enumerate(each.kills) if kill.fault == fault]
    good = [each for each, difference in zip(rounds, differences, strict=True) if difference is not None]
    repeated = 0
    for each, i, kill in mine:
        until = each.kills[i + 1].time if i + 1 < len(each.kills) else float("inf")
        starts = (e for e in each.journal if e.event == "start" and kill.time < e.time <= until)
        repeated += sum(e.time > each.stored.get(e.unit, float("inf")) for e in starts)
    recovered = [seconds for each, _, kill in mine if (seconds := kill.recovered(each)) is not None]
    return {
        "fault": fault,
        "kills": len(mine),
        "ended": sum(each in good for each, _, _ in mine),
        "repeated": repeated,
        "lost_in_flight": sum(kill.lost(each) for each, _, kill in mine),
        "recovered_s": round(statistics.median(recovered), 2) if recovered else None,
    }


def _difference(reference: pd.DataFrame, frame: pd.DataFrame | None) -> float | None:
    """Largest relative difference of costs; None unless rows, patterns and statuses are equal and it is <= 1e-9."""
    columns = [*task_columns(reference.columns), "pattern", "gait", "seed", "status"]
    if frame is None or not reference[columns].equals(frame[columns]):
        return None
    if not reference["cost"].isna().equals(frame["cost"].isna()):
        return None
    largest = float(((frame["cost"] - reference["cost"]).abs() / reference["cost"].abs()).max())
    return largest if largest <= 1e-9 else None


def _pid(entry: Entry) -> int:
    return int(entry.solver.partition("-")[0])


def _in_work(pid: int) -> bool:
    """Whether a solver process is at work for this run: a child of a worker."""
    return any(_descendants(worker) for worker in _workers(pid))


def _workers(pid: int) -> list[int]:
    return [child for child in _children(pid) if b"spawn_main" in _command(child)]


def _descendants(pid: int) -> list[int]:
    return [each for child in _children(pid) for each in (child, *_descendants(child))]


def _children(pid: int) -> list[int]:
    try:
        threads = list(Path(f"/proc/{pid}/task").iterdir())
        return [int(child) for thread in threads for child in (thread / "children").read_text().split()]
    except OSError:
        return []


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def _alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def _wait(run: subprocess.Popen[bytes], seconds: float) -> bool:
    """Whether the run ended within that time."""
    try:
        run.wait(seconds)
    except subprocess.TimeoutExpired:
        return False
    return True


def main() -> None:
    """Print the document, or write it to `--output`."""
    parser = argparse.ArgumentParser(description="kill -9 of workers and of whole runs at random moments")
    parser.add_argument("--scenario", type=Path, default=Path("configs/scenarios/quickstart.yaml"))
    parser.add_argument("--tasks", type=int, default=12)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    document = faults(load_scenario(options.scenario), options.tasks, options.kills, options.seed)
    text = json.dumps(document, indent=2) + "\n"
    if options.output:
        options.output.write_text(text, encoding="utf-8")
    else:
        print(text, end="")
    summary = document["summary"]
    bad = summary["repeated"] or summary["orphans"] or summary["ended"] < summary["kills"]
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
