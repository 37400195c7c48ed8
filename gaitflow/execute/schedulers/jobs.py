"""The jobs of one run in the queue: listed for all who ask, and cancelled."""

from __future__ import annotations

import json
import threading
import time
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

from gaitflow.execute.schedulers.base import DRIVER, Job, Scheduler, job_mark
from gaitflow.files import WriteError, atomic_write

ASK_EVERY_S = 30.0  # a scheduler answers everybody's questions, so nobody should ask often


def jobs_of(run_folder: Path, scheduler: Scheduler, max_age_s: float = ASK_EVERY_S) -> tuple[Job, ...]:
    """Jobs of this run that are in the queue, from a listing of at most this age [s]. Raises SchedulerError.

    Where the run has a folder `cluster`, the listing is kept there, so that all who ask share one.
    """
    kept = run_folder / "cluster" / "jobs.json"
    if max_age_s > 0 and (jobs := _read_listing(kept, max_age_s)) is not None:
        return jobs
    jobs = scheduler.jobs(job_mark(run_folder, ""))
    if kept.parent.is_dir():
        data = {"time": time.time(), "jobs": [asdict(job) for job in jobs]}
        with suppress(WriteError):  # a full disk is no reason not to answer
            atomic_write(kept, json.dumps(data).encode())
    return jobs


def cancel_run(run_folder: Path, scheduler: Scheduler) -> tuple[Job, ...]:
    """End all jobs of this run, and only them; which they were. Raises SchedulerError."""
    jobs = tuple(job for job in jobs_of(run_folder, scheduler, max_age_s=0) if job.alive)
    # The driver first: it would replace the workers.
    scheduler.cancel(job.id for job in sorted(jobs, key=lambda job: job.role != DRIVER))
    return jobs


class Queue:
    """The listing of a run's jobs for one that looks again and again: the scheduler is asked every 30 s at most."""

    def __init__(self, run_folder: Path, scheduler: Scheduler) -> None:
        self._folder, self._scheduler = run_folder, scheduler
        self._asked = -float("inf")
        self._lock = threading.Lock()

    def news(self) -> tuple[tuple[Job, ...], float] | None:
        """The jobs and when they were listed (time.monotonic [s]); None when it is too early. Raises SchedulerError."""
        with self._lock:
            now = time.monotonic()
            if now - self._asked < ASK_EVERY_S:
                return None
            self._asked = now
        return jobs_of(self._folder, self._scheduler, max_age_s=0), now


def _read_listing(path: Path, max_age_s: float) -> tuple[Job, ...] | None:
    try:
        data = json.loads(path.read_bytes())
        if not 0 <= time.time() - data["time"] <= max_age_s:
            return None
        return tuple(Job(**{key: str(value) for key, value in job.items()}) for job in data["jobs"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
