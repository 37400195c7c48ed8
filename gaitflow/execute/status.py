"""How far a run is, read from its folder: while it runs, after it, from another machine, without Dask or Slurm."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gaitflow.config.scenario import Scenario
from gaitflow.execute.schedulers.jobs import DRIVER, SlurmError, jobs_of
from gaitflow.store.attempts import LostAttempt
from gaitflow.store.journal import read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_units

LATEST_ERRORS = 5


@dataclass(frozen=True)
class JobCounts:
    """Jobs in Slurm's queue by state ("RUNNING"), and by reason those that wait ("Priority")."""

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

    `cpu_hours_left` is None while nothing is solved. `quarantined` parts and packs were damaged. `errors` are the
    latest attempts that the solver did not survive, newest first. `jobs` is None for a run that never was on a cluster,
    and where Slurm cannot be asked. `logs` is the folder of the jobs' output, None without one.
    """

    scenario: str
    units: int
    solved: int
    failed: int
    left: int
    quarantined: int
    cpu_hours_spent: float
    cpu_hours_left: float | None
    errors: tuple[LostAttempt, ...]
    jobs: JobCounts | None
    logs: str | None

    def as_data(self) -> dict[str, Any]:
        """Plain JSON data."""
        return asdict(self)


def run_status(scenario: Scenario, store: UnitStore) -> RunStatus:
    """The state of a scenario's run as its store tells it; nothing is written."""
    planned = {unit.digest for unit in plan_units(scenario)}
    stored = store.solved() & planned
    failed = store.attempts.given_up() & stored
    left = len(planned) - len(stored)
    spent = {e.unit: e.cpu_s for e in read_journal(store.folder / "journal") if e.event == "stored" and e.kept}
    hours = sum(cpu for unit, cpu in spent.items() if unit in planned) / 3600
    known = len(spent.keys() & planned)
    return RunStatus(
        scenario=scenario.name,
        units=len(planned),
        solved=len(stored) - len(failed),
        failed=len(failed),
        left=left,
        quarantined=sum(file.suffix in (".parquet", ".pack") for file in (store.folder / "quarantine").glob("*")),
        cpu_hours_spent=hours,
        cpu_hours_left=hours / known * left if known else (0.0 if not left else None),
        errors=tuple(store.attempts.latest(LATEST_ERRORS)),
        jobs=_jobs(store.folder),
        logs=str(logs) if (logs := store.folder / "logs").is_dir() else None,
    )


def _counts(states: dict[str, int]) -> str:
    return ", ".join(f"{number} {state.lower()}" for state, number in sorted(states.items()))


def _jobs(run_folder: Path) -> JobCounts | None:
    if not (run_folder / "cluster").is_dir():
        return None
    try:
        jobs = jobs_of(run_folder)
    except SlurmError:
        return None
    waiting = Counter(job.reason for job in jobs if job.state == "PENDING")
    driver = Counter(job.state for job in jobs if job.role == DRIVER)
    workers = Counter(job.state for job in jobs if job.role != DRIVER)
    return JobCounts(dict(driver), dict(workers), dict(waiting))
