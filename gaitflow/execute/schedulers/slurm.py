"""Slurm. The only place that calls sbatch, squeue, sinfo and scancel."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

from gaitflow.execute.schedulers.base import NOTICE_S, DriverShell, Job, Partition, Request, SchedulerError, one_line
from gaitflow.execute.schedulers.commands import batches, call

_FORMAT = "%i|%T|%j|%k|%r"


class Slurm:
    """Jobs carry their mark in their comment. USR1 comes before the end of a walltime, TERM by scancel and preemption.

    After a preemption, or when a node is lost, Slurm requeues the driver itself.
    """

    name = "slurm"
    submit_command = "sbatch"
    partitions_command = "sinfo"

    def header(self, request: Request) -> str:
        """As in `Scheduler`."""
        # %j is the job's id, and a % of the folder's own is doubled.
        folder = one_line(request.log.parent).replace("%", "%%")
        log = request.log.name.format(id="%j")
        lines = [
            f"--job-name={request.name}",
            f"--comment={request.mark}",
            f"--output={_quoted(f'{folder}/{log}')}",
            "--open-mode=append",
            f"--time={request.walltime}",
            f"--mem={request.memory.removesuffix('B')}",
            "--nodes=1",
            "--ntasks=1",
            f"--cpus-per-task={request.cores}",
        ]
        lines += [f"--partition={request.partition}"] if request.partition else []
        lines += [f"--account={request.account}"] if request.account else []
        lines += ["--requeue", f"--signal=B:USR1@{NOTICE_S}"] if request.requeued else ["--no-requeue"]
        return "\n".join(f"#SBATCH {line}" for line in [*lines, *request.directives])

    def driver_shell(self, walltime_s: int, script: Path) -> DriverShell:
        """As in `Scheduler`: Slurm keeps the script itself."""
        return DriverShell("$SLURM_JOB_ID", "${SLURM_RESTART_COUNT:-0}", 'scontrol requeue "$SLURM_JOB_ID"')

    def submit(self, script: str) -> str:
        """As in `Scheduler`."""
        return job_id(call(["sbatch", "--parsable"], "Slurm", script))

    def check(self, script: str) -> None:
        """As in `Scheduler`."""
        call(["sbatch", "--test-only"], "Slurm", script)

    def jobs(self, mark: str) -> tuple[Job, ...]:
        """As in `Scheduler`."""
        return parse_queue(
            call(["squeue", "--noheader", f"--user={os.getuid()}", f"--format={_FORMAT}"], "Slurm"), mark
        )

    def cancel(self, ids: Iterable[str]) -> None:
        """As in `Scheduler`."""
        for some in batches(list(ids)):
            call(["scancel", "--quiet", *some], "Slurm")

    def version(self) -> str:
        """As in `Scheduler`."""
        return call(["sbatch", "--version"], "Slurm").strip()

    def partition(self, name: str | None) -> Partition | None:
        """As in `Scheduler`."""
        arguments = [f"--partition={name}"] if name else []
        for line in call(["sinfo", "--noheader", *arguments, "--format=%R|%P|%a|%l|%D"], "Slurm").splitlines():
            fields = line.strip().split("|")
            if len(fields) == 5 and (name or fields[1].endswith("*")):
                return Partition(fields[0], fields[2] == "up", _limit(fields[3]), int(fields[4]))
        return None


def job_id(answer: str) -> str:
    """The id in what `sbatch --parsable` printed, `<id>[;<cluster>]` on its last line. Raises SchedulerError."""
    lines = answer.split()
    found = re.fullmatch(r"(\d+)(;.*)?", lines[-1]) if lines else None
    if found is None:
        raise SchedulerError(f"sbatch answered {answer.strip()!r}, which is no job id; was the job submitted?")
    return found[1]


def parse_queue(listing: str, mark: str) -> tuple[Job, ...]:
    """The jobs whose mark begins like this among the lines of squeue."""
    jobs = []
    for line in listing.splitlines():
        fields = line.split("|", 4)
        if len(fields) == 5 and fields[3].startswith(mark):
            number, state, name, comment, reason = fields
            jobs.append(Job(number, name, state, reason, comment.removeprefix(mark)))
    return tuple(jobs)


def _limit(text: str) -> int | None:
    """Seconds in sinfo's "1-00:00:00", "2:00:00" or "30:00"; None for "infinite" and what else is no time."""
    match = re.fullmatch(r"(?:(\d+)-)?(?:(\d+):)?(\d+):(\d+)", text)
    if match is None:
        return None
    days, hours, minutes, seconds = (int(part or 0) for part in match.groups())
    return ((days * 24 + hours) * 60 + minutes) * 60 + seconds


def _quoted(text: str) -> str:
    """As sbatch reads its own lines: words, quotes, backslashes."""
    return text if re.fullmatch(r"[\w./%@+=:,-]*", text, re.ASCII) else '"' + re.sub(r'(["\\])', r"\\\1", text) + '"'
