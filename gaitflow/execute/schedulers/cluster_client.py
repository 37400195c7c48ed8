"""A Dask cluster made of jobs: its scheduler in this process, the workers long-lived jobs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import dask
from distributed import Client

from gaitflow.config.cluster import Profile
from gaitflow.execute.drivers import the_driver
from gaitflow.execute.open_files import allow_connections
from gaitflow.execute.schedulers.choice import record_scheduler, scheduler_of
from gaitflow.execute.schedulers.pool import OnNote, WorkerPool
from gaitflow.execute.settings import CLUSTER_SETTINGS
from gaitflow.execute.tls import session_security


@contextmanager
def cluster_client(
    profile: Profile, run_folder: Path, longest_unit_s: float, on_note: OnNote = lambda note: None
) -> Iterator[Client]:
    """A client of `profile.jobs` workers that are kept in the queue; at the end of the block all are cancelled.

    `run_folder` has to be on a file system that all nodes share: the credentials and the logs are there. No unit
    takes longer than `longest_unit_s`. `on_note` hears, from another thread, what a user should know: jobs lost or
    refused, or too few open files for so many workers. Raises DriverAlive when this run has a driver already,
    SchedulerError, OSError.
    """
    scheduler = scheduler_of(profile)
    for name in ("cluster", "logs"):
        (run_folder / name).mkdir(parents=True, exist_ok=True)
    if note := allow_connections(profile.jobs):
        on_note(note)
    credentials = session_security(run_folder) if profile.tls else nullcontext()
    with (
        the_driver(run_folder, scheduler),
        credentials as security,
        dask.config.set(CLUSTER_SETTINGS),
        WorkerPool(scheduler, profile, run_folder, longest_unit_s, security, on_note) as pool,
        Client(pool) as client,
    ):
        record_scheduler(run_folder, scheduler)
        pool.keep_up()
        try:
            yield client
        finally:
            pool.end_jobs()
