"""How far a run is, read from its folder: while it runs, after it, from another machine, without Dask."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.execute.drivers import driver_process
from gaitflow.execute.schedulers.base import DRIVER, SchedulerError
from gaitflow.execute.schedulers.choice import recorded_scheduler
from gaitflow.execute.schedulers.jobs import jobs_of
from gaitflow.store.attempts import LostAttempt
from gaitflow.store.journal import read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

LATEST_ERRORS = 5


@dataclass(frozen=True)
class JobCounts:
    """Jobs in the queue by state ("RUNNING"), and by reason those that wait ("Priority")."""

    driver: dict[str, int]
    workers: dict[str, int]
    waiting_for: dict[str, int]

    def __str__(self) -> str:
        groups = (("driver", self.driver), ("workers", self.workers))
        texts = [f"{name} {_counts(states)}" for name, states in groups if states]
        texts += [f"waiting for {', '.join(self.waiting_for)}"] if self.waiting_for else []
        return "; ".join(texts) or "none in the queue"


@dataclass(frozen=True)
class RunStatus:
    """Counts of units (`units` = `solved` + `failed` + `left`), CPU hours spent and, from them, still to spend.

    `solves` are all that were done, also those of units that are `begun` and not finished; an interruption keeps them.
    `driver` is the process or the job that drives the run, None when nobody does. `cpu_hours_left` is None while no
    unit is solved. `quarantined` parts and packs were damaged. `errors` are the
    latest attempts that the solver did not survive, newest first. `jobs` is None for a run that never was on a cluster,
    and where its scheduler cannot be asked. `logs` is the folder of the jobs' output, None without one.
    """

    scenario: str
    units: int
    solved: int
    failed: int
    left: int
    begun: int
    solves: int
    driver: str | None
    quarantined: int
    cpu_hours_spent: float
    cpu_hours_left: float | None
    errors: tuple[LostAttempt, ...]
    jobs: JobCounts | None
    logs: str | None

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data."""
        return asdict(self)


def run_status(scenario: Scenario, store: UnitStore, chosen: Sequence[Task] | None = None) -> RunStatus:
    """The state of a scenario's run as its store tells it; nothing is written.

    `chosen` are the tasks that an adaptive sampling has chosen so far.
    """
    return units_status(scenario.name, plan_units(scenario, chosen), store)


def units_status(name: str, units: Iterable[Unit], store: UnitStore) -> RunStatus:
    """The same of any units of work; `name` is what the run is called."""
    planned = {unit.digest for unit in units}
    stored = store.solved() & planned
    failed = store.attempts.given_up() & stored
    left = len(planned) - len(stored)
    entries = [entry for entry in read_journal(store.folder / "journal") if entry.unit in planned]
    spent = {entry.unit: entry for entry in entries if entry.event == "stored" and entry.kept}
    begun = {entry.unit: entry for entry in entries if entry.event == "progress" and entry.unit not in stored}
    hours = sum(entry.cpu_s for entry in spent.values()) / 3600
    hours_begun = sum(entry.cpu_s for entry in begun.values()) / 3600
    hours_left = hours / len(spent) * left - hours_begun if spent else (0.0 if not left else None)
    jobs = _jobs(store.folder)
    return RunStatus(
        scenario=name,
        units=len(planned),
        solved=len(stored) - len(failed),
        failed=len(failed),
        left=left,
        begun=len(begun),
        solves=sum(entry.solves for entry in (*spent.values(), *begun.values())),
        driver=_driver(store.folder, jobs),
        quarantined=sum(file.suffix in (".parquet", ".pack") for file in (store.folder / "quarantine").glob("*")),
        cpu_hours_spent=hours + hours_begun,
        cpu_hours_left=None if hours_left is None else max(hours_left, 0.0),
        errors=tuple(store.attempts.latest(LATEST_ERRORS)),
        jobs=jobs,
        logs=str(logs) if (logs := store.folder / "logs").is_dir() else None,
    )


def _driver(run_folder: Path, jobs: JobCounts | None) -> str | None:
    if jobs is not None and jobs.driver:
        return f"a job, {_counts(jobs.driver)}"
    return driver_process(run_folder)


def _counts(states: dict[str, int]) -> str:
    return ", ".join(f"{number} {state.lower()}" for state, number in sorted(states.items()))


def _jobs(run_folder: Path) -> JobCounts | None:
    if not (run_folder / "cluster").is_dir():
        return None
    try:
        jobs = jobs_of(run_folder, recorded_scheduler(run_folder))
    except SchedulerError:
        return None
    waiting = Counter(job.reason for job in jobs if job.state == "PENDING")
    driver = Counter(job.state for job in jobs if job.role == DRIVER)
    workers = Counter(job.state for job in jobs if job.role != DRIVER)
    return JobCounts(dict(driver), dict(workers), dict(waiting))
