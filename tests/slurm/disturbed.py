"""A run on the tests' Slurm that is disturbed: its driver, its solvers, and what the disturbance cost.

What happened is judged from outside: processes, the journal and the parts' times, not by the code under test.
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import fakes
import pandas as pd
import yaml
from cluster import Cluster

from benchmarks.document import document
from gaitflow.config.cluster import load_profile
from gaitflow.config.scenario import Scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.execute.schedulers.scripts import driver_script
from gaitflow.execute.schedulers.slurm import Slurm
from gaitflow.store.journal import Entry, read_journal, unended
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

POOL = 3
SLOW_S, QUICK_S = 3.0, 0.05  # how long a unit takes, before and after the pool is back
POOL_WITHIN_S = 150.0
ENDS_WITHIN_S = 120.0
LEAVES_WITHIN_S = 30.0  # Slurm's KillWait of 5 s, and what completing takes
MOVING = ["wall_s", "cpu_s"]  # columns that no two runs have in common
TICK_S = 0.02  # by which the clock of a file system may lag behind the process's


@dataclass(frozen=True)
class Row:
    """What a fault did. `lost_in_flight`: units begun by solvers that it hit and finished by others. `repeated`:
    begun again after they were stored. `recovered_s`: seconds until as many solvers as wanted were at work again."""

    fault: str
    ended: bool
    lost_in_flight: int
    repeated: int
    recovered_s: float | None


class Run:
    """One run of `scenario` below `folder`, driven by a process of its own, with POOL workers on `cluster`."""

    def __init__(self, cluster: Cluster, scenario: Scenario, folder: Path, **profile: Any) -> None:
        self.cluster, self.scenario, self.folder = cluster, scenario, folder
        self.store = UnitStore(folder / "runs" / scenario.name)
        self.marks = folder / "marks"
        self.marks.mkdir(parents=True)
        self.pace(SLOW_S)
        self._process: subprocess.Popen[bytes] | None = None
        self._job: str | None = None
        settings = {"name": "test", "partition": "work", "walltime": "00:10:00", "memory": "500MB", "jobs": POOL}
        settings |= {"interface": "lo", "margin_s": 20, "driver": {"memory": "1GB"}, **profile}
        self.profile = folder / "profile.yaml"
        self.profile.write_text(yaml.safe_dump(settings))
        self._scenario_file = folder / "scenario.json"
        self._scenario_file.write_text(json.dumps(scenario.as_data()))

    def start(self, solve: str = "fakes:paced", **environment: str) -> None:
        """Start the driver, or another one after the first."""
        with open(self.folder / "driver.log", "ab") as log:
            self._process = subprocess.Popen(
                self._command(solve),
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env=os.environ | {"FAKE_FOLDER": str(self.marks), **environment},
                start_new_session=True,
            )

    def submit(self) -> str:
        """Start the driver as a job, by the very script of `gaitflow submit`, and return the job's id.

        Only the program is another one: in the place of `gaitflow solve` it solves with the tests' solver.
        """
        program, script = self.folder / "python", self.folder / "driver.sh"
        program.write_text(
            f"#!/bin/bash\nexport FAKE_FOLDER={shlex.quote(str(self.marks))}\n"
            f"case \" $* \" in *' solve '*) exec {shlex.join(self._command('fakes:paced'))} ;; esac\n"
        )
        program.chmod(0o755)
        (self.store.folder / "logs").mkdir(parents=True)
        profile, name = load_profile(self.profile), self.scenario.name
        folders = self.store.folder, self.folder
        script.write_text(driver_script(Slurm(), profile, *folders, name, self.profile, script, str(program)))
        self._job = self.cluster.call("sbatch", "--parsable", str(script)).strip()
        return self._job

    def driver(self) -> int:
        """The process that drives the run, and holds Dask's scheduler, inside its job."""
        (pid,) = (pid for pid in self.cluster.job_processes(job=self._job) if b"drive.py" in _command(pid))
        return pid

    @property
    def log(self) -> str:
        """All that the drivers said."""
        logs = [self.folder / "driver.log", *self.store.folder.glob("logs/driver-*.log")]
        return "".join(log.read_text(errors="replace") for log in logs if log.exists())

    def pace(self, seconds: float) -> None:
        """From now on a unit takes so long, also one that is being solved."""
        new = self.marks / "pace.new"
        new.write_text(str(seconds))
        new.replace(self.marks / "pace")

    def solvers(self, job: str | None = None) -> set[int]:
        """Solver processes in the cluster's jobs, or in one job."""
        return {pid for pid in self.cluster.job_processes(job=job) if b"solver_process" in _command(pid)}

    def jobs(self) -> list[str]:
        """Ids of the workers' jobs that are running."""
        running = self.cluster.call("squeue", "-h", "-t", "running", "-p", "work", "-o", "%A").split()
        return [job for job in running if job != self._job]

    def wait_for_pool(self, without: Collection[int] = ()) -> float:
        """Wait until POOL solvers, none of them in `without`, have begun a unit; the time when that was seen."""
        self.wait_until(lambda: len((self.solvers() - set(without)) & {solver_pid(e) for e in self.journal()}) >= POOL)
        return time.time()

    def wait_until(self, condition: Callable[[], object], seconds: float = POOL_WITHIN_S) -> None:
        """Wait for something to happen while the driver runs."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, f"it took more than {seconds:.0f} s\n{self.log[-3000:]}"
            assert self._exit_code() is None, f"the run ended\n{self.log[-3000:]}"
            time.sleep(0.1)

    def kill_driver(self) -> None:
        """kill -9 the driver."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()

    def finish(self) -> int:
        """Wait for the driver to end; its exit code. No job may be left in the queue then."""
        self.pace(QUICK_S)
        deadline = time.monotonic() + ENDS_WITHIN_S
        while (code := self._exit_code()) is None:
            assert time.monotonic() < deadline, f"the run did not end\n{self.log[-3000:]}"
            time.sleep(0.1)
        deadline = time.monotonic() + LEAVES_WITHIN_S
        while left := self.cluster.call("squeue", "-h", "-o", "%A %j %T", "-p", "work"):
            assert time.monotonic() < deadline, f"left in the queue:\n{left}"
            time.sleep(0.2)
        return code

    def close(self) -> None:
        """Whatever happened, leave no driver behind."""
        if self._process is not None and self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()

    def _command(self, solve: str) -> list[str]:
        program = Path(__file__).with_name("drive.py")
        return [sys.executable, *map(str, (program, self._scenario_file, self.store.folder, solve, self.profile))]

    def _exit_code(self) -> int | None:
        """Of the driver; None while it runs, or waits in the queue."""
        if self._job is None:
            assert self._process is not None
            return self._process.poll()
        if self._job in self.cluster.call("squeue", "-h", "-o", "%A").split():
            return None
        last = [line for line in self.cluster.completed().splitlines() if f"JobId={self._job} " in line][-1]
        return 0 if "JobState=COMPLETED" in last else 1

    def journal(self) -> list[Entry]:
        """The run's journal."""
        return read_journal(self.store.folder / "journal")

    def lost_solves(self) -> int:
        """Solves whose end nobody saw."""
        return sum(map(len, unended(self.store.folder / "journal").values()))

    def row(self, fault: str, hit: Iterable[int], recovered_s: float | None) -> Row:
        """What the fault did that hit these solver processes."""
        victims, journal = set(hit), self.journal()
        stored = {digest: self.store.path(digest).stat().st_mtime + TICK_S for digest in self.store.solved()}
        kept = {entry.unit: solver_pid(entry) for entry in journal if entry.kept}
        begun = {entry.unit for entry in journal if entry.event == "start" and solver_pid(entry) in victims}
        return Row(
            fault=fault,
            ended=stored.keys() == {unit.digest for unit in plan_units(self.scenario)},
            lost_in_flight=sum(kept.get(unit) not in victims for unit in begun),
            repeated=sum(e.event == "start" and e.time > stored.get(e.unit, float("inf")) for e in journal),
            recovered_s=None if recovered_s is None else round(recovered_s, 1),
        )

    def dataset(self) -> pd.DataFrame:
        """The collected rows, without what times a solve."""
        return load_solutions(collect(self.store, self.scenario)).frame().drop(columns=MOVING)


def undisturbed(scenario: Scenario, folder: Path) -> pd.DataFrame:
    """The rows of a run in this very process, to compare with."""
    store = UnitStore(folder)
    for unit in plan_units(scenario):
        store.write(unit, fakes.steady(unit.scenario, unit.tasks, unit.seeds, None), {})
    return load_solutions(collect(store, scenario)).frame().drop(columns=MOVING)


def fault_document(rows: Sequence[Row]) -> dict[str, Any]:
    """The bench document of these rows."""
    summary = {
        "faults": len(rows),
        "ended": sum(row.ended for row in rows),
        "repeated": sum(row.repeated for row in rows),
        "lost_in_flight": sum(row.lost_in_flight for row in rows),
        "pool": POOL,
    }
    notes = [
        "The solver sleeps; Slurm has three nodes on one machine; every dataset equals the undisturbed one.",
        "lost_in_flight: units begun by solvers that were hit and finished by others.",
        "repeated: units begun again after they were stored.",
        "recovered_s: from the fault until a full pool of other solvers was at work; without a fault from the start.",
    ]
    return document("slurm-faults", None, [asdict(row) for row in rows], summary, notes)


def solver_pid(entry: Entry) -> int:
    """The process that wrote a line of the journal."""
    return int(entry.solver.partition("-")[0])


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""
