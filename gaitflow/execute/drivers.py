"""At most one driver a run: two would solve the same units, and cancel each other's workers.

A process that drives a run writes `<run folder>/driver.json`, with its host, user and start time. A record whose
process is gone, on this host, is ignored.
"""

from __future__ import annotations

import fcntl
import getpass
import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gaitflow.execute.schedulers.base import DRIVER, Scheduler, SchedulerError
from gaitflow.execute.schedulers.choice import recorded_scheduler
from gaitflow.execute.schedulers.jobs import jobs_of
from gaitflow.files import atomic_write

IN_DRIVER_JOB = "GAITFLOW_DRIVER_JOB"  # set by the driver's script: the id of its job


class DriverAlive(RuntimeError):
    """The run has a driver already; the message says where, and how to end it."""


def refuse_second_driver(run_folder: Path, scheduler: Scheduler) -> None:
    """Raises DriverAlive when a job or a process drives this run, SchedulerError when it cannot be asked."""
    name = run_folder.resolve().name
    for job in jobs_of(run_folder, scheduler, max_age_s=0):
        if job.role == DRIVER and job.alive:
            raise DriverAlive(
                f"{name}: the driver job {job.id} is {job.state.lower()}; watch it with `gaitflow status {name}`, "
                f"or end it first with `gaitflow cancel {name}`"
            )
    _refuse_second_process(run_folder)


def driver_process(run_folder: Path) -> str | None:
    """The process that drives this run outside of a job: "the process 7 of anna on login1"; None without one."""
    try:
        held = json.loads(_record(run_folder).read_bytes())
        host, pid, user, started = str(held["host"]), int(held["pid"]), str(held["user"])[:80], held["started"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    if host == socket.gethostname() and (pid == os.getpid() or _start_of(pid) != started):
        return None
    return f"the process {pid} of {user} on {host}"


@contextmanager
def the_driver(run_folder: Path, scheduler: Scheduler) -> Iterator[None]:
    """Be the run's driver on a cluster for a block. Raises DriverAlive when it has one, SchedulerError, WriteError."""
    if IN_DRIVER_JOB in os.environ:  # `submit` has looked, and a requeued job is the same one
        yield
        return
    refuse_second_driver(run_folder, scheduler)
    with _recorded(run_folder):
        yield


@contextmanager
def the_local_driver(run_folder: Path) -> Iterator[None]:
    """Be the run's driver on this machine alone for a block. Raises DriverAlive when there is another, WriteError."""
    if (run_folder / "cluster").is_dir():
        with suppress(SchedulerError):  # the folder may have been copied from a cluster
            refuse_second_driver(run_folder, recorded_scheduler(run_folder))
    with _recorded(run_folder):
        yield


@contextmanager
def _recorded(run_folder: Path) -> Iterator[None]:
    record, pid = _record(run_folder), os.getpid()
    held = {"host": socket.gethostname(), "pid": pid, "user": getpass.getuser(), "started": _start_of(pid)}
    run_folder.mkdir(parents=True, exist_ok=True)
    with open(record.with_suffix(".lock"), "a") as lock:  # so that of two that look at once one writes
        fcntl.flock(lock, fcntl.LOCK_EX)
        _refuse_second_process(run_folder)
        atomic_write(record, json.dumps(held).encode())
    try:
        yield
    finally:
        with suppress(OSError):
            record.unlink()


def _refuse_second_process(run_folder: Path) -> None:
    process = driver_process(run_folder)
    if process is not None:
        raise DriverAlive(
            f"{run_folder.resolve().name}: {process} solves it; end that one first, or remove {_record(run_folder)} "
            "when it is gone"
        )


def _record(run_folder: Path) -> Path:
    return run_folder / "driver.json"


def _start_of(pid: int) -> str | None:
    """When a process of this host started, in ticks since it was booted; None when there is none."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return None if fields[0] == "Z" else fields[19]
