"""The jobs of one run in Slurm's queue: submit, list, cancel. The only place that calls sbatch, squeue and scancel.

A run's jobs carry its tag in their comment, `gaitflow:<tag>:<role>`, so that nothing else is ever counted or cancelled.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import threading
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from gaitflow.files import WriteError, atomic_write

SQUEUE_EVERY_S = 30.0  # Slurm's controller answers everybody's squeue, so nobody should ask often
COMMAND_LIMIT_S = 120.0
SCANCEL_AT_ONCE = 500  # ids in one command
DRIVER = "driver"
# States of a job that holds its place; any other is on its way out.
ALIVE = frozenset(
    ("PENDING", "CONFIGURING", "RUNNING", "SUSPENDED", "STOPPED", "RESIZING", "SIGNALING", "REQUEUED", "REQUEUE_HOLD")
)
_FORMAT = "%i|%T|%j|%k|%r"


class SlurmError(RuntimeError):
    """One of Slurm's commands is missing or failed; the message says which, what it answered and what to do."""


@dataclass(frozen=True)
class Job:
    """One job: `id`, `name`, `state` as Slurm names it ("PENDING"), `reason` why it waits, `role`.

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
    """A partition of the cluster: `limit_s` is the longest walltime [s], None without a limit."""

    name: str
    up: bool
    limit_s: int | None
    nodes: int


def run_tag(run_folder: Path) -> str:
    """What marks the jobs of the run in this folder: 16 hexadecimal digits of the folder's absolute name."""
    return hashlib.sha256(os.fsencode(run_folder.resolve())).hexdigest()[:16]


def comment(run_folder: Path, role: str) -> str:
    """The comment of a job of this run."""
    return f"gaitflow:{run_tag(run_folder)}:{role}"


def submit(script: str) -> str:
    """Hand an sbatch script to Slurm and return the job's id. Raises SlurmError."""
    return job_id(_call(["sbatch", "--parsable"], script))


def check(script: str) -> None:
    """Have Slurm say whether it would ever run this sbatch script; nothing is submitted. Raises SlurmError."""
    _call(["sbatch", "--test-only"], script)


def job_id(answer: str) -> str:
    """The id in what `sbatch --parsable` printed, `<id>[;<cluster>]` on its last line. Raises SlurmError."""
    lines = answer.split()
    found = re.fullmatch(r"(\d+)(;.*)?", lines[-1]) if lines else None
    if found is None:
        raise SlurmError(f"sbatch answered {answer.strip()!r}, which is no job id; was the job submitted?")
    return found[1]


def jobs_of(run_folder: Path, max_age_s: float = SQUEUE_EVERY_S) -> tuple[Job, ...]:
    """Jobs of this run that are in the queue, from a listing of at most this age [s]. Raises SlurmError.

    Where the run has a folder `cluster`, the listing is kept there, so that all who ask share one squeue.
    """
    kept = run_folder / "cluster" / "jobs.json"
    if max_age_s > 0 and (jobs := _read_listing(kept, max_age_s)) is not None:
        return jobs
    jobs = parse_queue(_call(["squeue", "--noheader", f"--user={os.getuid()}", f"--format={_FORMAT}"]), run_folder)
    if kept.parent.is_dir():
        data = {"time": time.time(), "jobs": [asdict(job) for job in jobs]}
        with suppress(WriteError):  # a full disk is no reason not to answer
            atomic_write(kept, json.dumps(data).encode())
    return jobs


def parse_queue(listing: str, run_folder: Path) -> tuple[Job, ...]:
    """The jobs of this run among the lines of squeue."""
    start = comment(run_folder, "")
    jobs = []
    for line in listing.splitlines():
        fields = line.split("|", 4)
        if len(fields) == 5 and fields[3].startswith(start):
            number, state, name, mark, reason = fields
            jobs.append(Job(number, name, state, reason, mark.removeprefix(start)))
    return tuple(jobs)


def cancel(ids: Iterable[str]) -> None:
    """End these jobs; those that have ended are no error. Raises SlurmError."""
    ids = list(ids)
    for start in range(0, len(ids), SCANCEL_AT_ONCE):
        _call(["scancel", "--quiet", *ids[start : start + SCANCEL_AT_ONCE]])


def cancel_run(run_folder: Path) -> tuple[Job, ...]:
    """End all jobs of this run, and only them; which they were. Raises SlurmError."""
    jobs = tuple(job for job in jobs_of(run_folder, max_age_s=0) if job.alive)
    # The driver first: it would replace the workers.
    cancel(job.id for job in sorted(jobs, key=lambda job: job.role != DRIVER))
    return jobs


def slurm_version() -> str:
    """Such as "slurm-wlm 22.05.8". Raises SlurmError."""
    return _call(["sbatch", "--version"]).strip()


def partition(name: str | None) -> Partition | None:
    """The partition of this name, or the default one; None when there is none. Raises SlurmError."""
    arguments = [f"--partition={name}"] if name else []
    for line in _call(["sinfo", "--noheader", *arguments, "--format=%R|%P|%a|%l|%D"]).splitlines():
        fields = line.strip().split("|")
        if len(fields) == 5 and (name or fields[1].endswith("*")):
            return Partition(fields[0], fields[2] == "up", _limit(fields[3]), int(fields[4]))
    return None


class Queue:
    """The listing of a run's jobs for one that looks again and again: squeue is asked every 30 s at most."""

    def __init__(self, run_folder: Path) -> None:
        self._folder = run_folder
        self._asked = -float("inf")
        self._lock = threading.Lock()

    def news(self) -> tuple[tuple[Job, ...], float] | None:
        """The jobs and when squeue was asked (time.monotonic [s]); None when it is too early. Raises SlurmError."""
        with self._lock:
            now = time.monotonic()
            if now - self._asked < SQUEUE_EVERY_S:
                return None
            self._asked = now
        return jobs_of(self._folder, max_age_s=0), now


def _read_listing(path: Path, max_age_s: float) -> tuple[Job, ...] | None:
    try:
        data = json.loads(path.read_bytes())
        if not 0 <= time.time() - data["time"] <= max_age_s:
            return None
        return tuple(Job(**{key: str(value) for key, value in job.items()}) for job in data["jobs"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def _call(command: Sequence[str], script: str = "") -> str:
    try:
        done = subprocess.run(
            command,
            input=script,
            capture_output=True,
            text=True,
            timeout=COMMAND_LIMIT_S,
            check=False,
            errors="replace",
        )
    except FileNotFoundError:
        raise SlurmError(f"{command[0]}: not found; run this where Slurm is, such as on a login node") from None
    except subprocess.TimeoutExpired:
        raise SlurmError(f"{command[0]}: no answer in {COMMAND_LIMIT_S:.0f} s; is Slurm's controller up?") from None
    if done.returncode:
        raise SlurmError(f"{command[0]}: {_last_line(done.stderr) or f'exit code {done.returncode}'}")
    return done.stdout


def _limit(text: str) -> int | None:
    """Seconds in sinfo's "1-00:00:00", "2:00:00" or "30:00"; None for "infinite" and what else is no time."""
    match = re.fullmatch(r"(?:(\d+)-)?(?:(\d+):)?(\d+):(\d+)", text)
    if match is None:
        return None
    days, hours, minutes, seconds = (int(part or 0) for part in match.groups())
    return ((days * 24 + hours) * 60 + minutes) * 60 + seconds


def _last_line(text: str) -> str:
    lines = text.strip().splitlines()
    return re.sub(r"^\w+: error: ", "", lines[-1]) if lines else ""
