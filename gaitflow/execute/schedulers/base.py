"""What is asked of a cluster's scheduler, whichever it is: `Slurm` and `Pbs` answer it.

A run's jobs carry its mark, `gaitflow:<tag>:<role>`, so that nothing else is ever counted or cancelled. States of jobs
have Slurm's names everywhere.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

DRIVER = "driver"
NOTICE_S = 60  # before the end of its walltime the driver is told to stop
# States of a job that holds its place; any other is on its way out.
ALIVE = frozenset(
    ("PENDING", "CONFIGURING", "RUNNING", "SUSPENDED", "STOPPED", "RESIZING", "SIGNALING", "REQUEUED", "REQUEUE_HOLD")
)


class SchedulerError(RuntimeError):
    """A command of the scheduler is missing or failed; the message says which, what it answered and what to do."""


@dataclass(frozen=True)
class Job:
    """One job: `id`, `name`, `state` ("PENDING"), `reason` why it waits, `role`.

    `role` is "driver" or the Dask name of a worker.
    """

    id: str
    name: str
    state: str
    reason: str
    role: str

    @property
    def alive(self) -> bool:
        """Whether it waits or runs, and does not only end."""
        return self.state in ALIVE


@dataclass(frozen=True)
class Partition:
    """A partition, or queue: `limit_s` is the longest walltime [s], None without a limit; `nodes` None if untold."""

    name: str
    up: bool
    limit_s: int | None
    nodes: int | None


@dataclass(frozen=True)
class Request:
    """What a job asks for. `{id}` in the name of `log` stands for the job's id.

    `messages` is the folder for what a scheduler says of a job that does not say it in the log, None for nowhere.
    `walltime` and `memory` are as in a profile, `requeued` whether the job goes back into the queue when its node is
    lost, `directives` the user's own.
    """

    name: str
    mark: str
    log: Path
    messages: Path | None
    walltime: str
    memory: str
    cores: int
    partition: str | None
    account: str | None
    requeued: bool
    directives: tuple[str, ...]


@dataclass(frozen=True)
class DriverShell:
    """What the driver's script needs of its scheduler, as bash: expressions, a command, and lines.

    `job` is its id, `restarts` how often it came back, `requeue` puts it back into the queue, and `notice` are lines
    that have USR1 sent to it before the end of its walltime, where no directive does so.
    """

    job: str
    restarts: str
    requeue: str
    notice: str = ""


class Scheduler(Protocol):
    """A scheduler and its commands. All that call one raise SchedulerError."""

    @property
    def name(self) -> str:
        """What a profile calls it."""

    @property
    def submit_command(self) -> str:
        """The command that takes a script's file, and prints the job's id as the first number."""

    @property
    def partitions_command(self) -> str:
        """What a user calls to see all partitions."""

    def header(self, request: Request) -> str:
        """The lines of a script that come first. Raises ValueError for a folder that no script can name."""

    def driver_shell(self, walltime_s: int, script: Path) -> DriverShell:
        """For a driver of this walltime [s], whose own script is kept in the file `script`."""

    def submit(self, script: str) -> str:
        """Submit the text of a script and return the job's id."""

    def check(self, script: str) -> None:
        """Have the scheduler say whether it would ever run this script, where it can; nothing is submitted."""

    def jobs(self, mark: str) -> tuple[Job, ...]:
        """The user's jobs in the queue whose mark begins like this; the rest of it is the role."""

    def cancel(self, ids: Iterable[str]) -> None:
        """End these jobs; those that have ended are no error."""

    def version(self) -> str:
        """Such as "slurm-wlm 22.05.8"."""

    def partition(self, name: str | None) -> Partition | None:
        """The partition of this name, or the default one; None when there is none."""


def run_tag(run_folder: Path) -> str:
    """What marks the jobs of the run in this folder: 16 hexadecimal digits of the folder's absolute name."""
    return hashlib.sha256(os.fsencode(run_folder.resolve())).hexdigest()[:16]


def job_mark(run_folder: Path, role: str) -> str:
    """The mark of a job of this run."""
    return f"gaitflow:{run_tag(run_folder)}:{role}"


def one_line(path: Path) -> str:
    """The whole path, as a line of a script. Raises ValueError for one that would break it."""
    text = str(path.resolve())
    if not text.isprintable():
        raise ValueError(f"{text!r}: cannot be named in a script of a job; move the project to another folder")
    return text
