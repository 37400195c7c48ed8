"""At most one driver a run: two would hand out the same units and cancel each other's workers."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gaitflow.execute.schedulers.jobs import DRIVER, jobs_of
from gaitflow.files import atomic_write

IN_DRIVER_JOB = "GAITFLOW_DRIVER_JOB"  # set by the driver's script: the id of its job


class DriverAlive(RuntimeError):
    """The run has a driver already; the message says where, and how to end it."""


def refuse_second_driver(run_folder: Path) -> None:
    """Raises DriverAlive when a job or a process drives this run, SlurmError when Slurm cannot be asked."""
    name = run_folder.resolve().name
    for job in jobs_of(run_folder, max_age_s=0):
        if job.role == DRIVER and job.alive:
            raise DriverAlive(
                f"{name}: the driver job {job.id} is {job.state.lower()}; watch it with `gaitflow status {name}`, "
                f"or end it first with `gaitflow cancel {name}`"
            )
    process = driver_process(run_folder)
    if process is not None:
        raise DriverAlive(
            f"{name}: {process} solves it; end that one first, or remove {_record(run_folder)} when it is gone"
        )


def driver_process(run_folder: Path) -> str | None:
    """The process that drives this run outside of a job, such as "the process 7 on login1"; None without one."""
    try:
        held = json.loads(_record(run_folder).read_bytes())
        host, pid = str(held["host"]), int(held["pid"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
    if host == socket.gethostname() and not _is_alive(pid):
        return None
    return f"the process {pid} on {host}"


@contextmanager
def the_driver(run_folder: Path) -> Iterator[None]:
    """Be the run's driver for a block. Raises DriverAlive when there is another one, SlurmError, WriteError."""
    if IN_DRIVER_JOB in os.environ:  # `submit` has looked, and a requeued job is the same one
        yield
        return
    refuse_second_driver(run_folder)
    record = _record(run_folder)
    atomic_write(record, json.dumps({"host": socket.gethostname(), "pid": os.getpid()}).encode())
    try:
        yield
    finally:
        with suppress(OSError):
            record.unlink()


def _record(run_folder: Path) -> Path:
    return run_folder / "cluster" / "driver.json"


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return pid != os.getpid()
