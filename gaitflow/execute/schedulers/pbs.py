"""PBS, as OpenPBS and PBS Professional have it. The only place that calls qsub, qselect, qstat and qdel.

Answers are read as text: in many versions that of `qstat -F json` is no JSON when a job's variables have quotes or
leading zeros in them, or leaves jobs out.
"""

from __future__ import annotations

import getpass
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from gaitflow.config.cluster import walltime_seconds
from gaitflow.execute.schedulers.base import NOTICE_S, DriverShell, Job, Partition, Request, SchedulerError, one_line
from gaitflow.execute.schedulers.commands import batches, call

# PBS's letters: queued, waiting, held, moving; running; suspended by the scheduler or by a node's owner.
_STATES = dict.fromkeys("QWHT", "PENDING") | {"R": "RUNNING", "S": "SUSPENDED", "U": "SUSPENDED"}
_HELD = "held; `qrls` releases it"
_MARK = "GAITFLOW_JOB"
_RESTARTS = "GAITFLOW_RESTARTS"
_JOB = "${PBS_JOBID%%.*}"
_GONE = "Unknown Job Id|Job has finished|Request invalid for state of job"  # what is said of jobs that end meanwhile

# PBS tells a job of the end of its walltime only by ending it. The sleep is ended with the script.
_NOTICE = """\
(
  trap 'kill "$nap"' TERM
  sleep {seconds} &
  nap=$!
  wait "$nap" && kill -USR1 $$
) > /dev/null 2>&1 < /dev/null &
notice=$!
trap 'kill "$notice" 2>/dev/null' EXIT
"""


class Record(NamedTuple):
    """One record of `qstat -f`: the job, queue or server, and its attributes."""

    name: str
    attributes: dict[str, str]


class Pbs:
    """Jobs carry their mark in a variable; ids are the numbers without the server's name.

    Scripts write their logs themselves, line by line: PBS would bring them when a job ends. What PBS itself says of a
    job goes into the folder `Request.messages`, as NAME.oNUMBER; None drops it. A driver comes back as a new job, since
    only operators may call qrerun; that of a lost node is run again by PBS.
    """

    name = "pbs"
    submit_command = "qsub"
    partitions_command = "qstat -Q"

    def header(self, request: Request) -> str:
        """As in `Scheduler`; ValueError also for a folder that PBS would not take as it is."""
        messages = "/dev/null" if request.messages is None else f"{_plain(request.messages)}/"
        lines = [
            f"-N {request.name}",
            f"-v {_MARK}={request.mark}",
            "-S /bin/bash",
            "-j oe",
            f"-o {messages}",
            f"-l select=1:ncpus={request.cores}:mem={request.memory.lower()}",
            f"-l walltime={_hours(request.walltime)}",
        ]
        lines += [f"-q {request.partition}"] if request.partition else []
        lines += [f"-A {request.account}"] if request.account else []
        lines += ["-r y" if request.requeued else "-r n", *request.directives]
        log = f"{_plain(request.log.parent)}/{request.log.name.format(id=_JOB)}"
        return "\n".join([*(f"#PBS {line}" for line in lines), f'exec >> "{log}" 2>&1'])

    def driver_shell(self, walltime_s: int, script: Path) -> DriverShell:
        """As in `Scheduler`."""
        restarts = f"${{{_RESTARTS}:-0}}"
        requeue = f'qsub -v "{_MARK}=${_MARK},{_RESTARTS}=$(({restarts} + 1))" {_plain(script)}'
        return DriverShell(_JOB, restarts, requeue, _NOTICE.format(seconds=walltime_s - NOTICE_S))

    def submit(self, script: str) -> str:
        """As in `Scheduler`."""
        return _number(call(["qsub"], "PBS", script))

    def check(self, script: str) -> None:
        """As in `Scheduler`: PBS has no way to say, and nothing is done."""

    def jobs(self, mark: str) -> tuple[Job, ...]:
        """As in `Scheduler`."""
        ids = call(["qselect", "-u", getpass.getuser()], "PBS").split()
        listings = [call(["qstat", "-f", *some], "PBS", harmless=_GONE) for some in batches(ids)]
        return tuple(job for listing in listings for job in parse_jobs(listing, mark))

    def cancel(self, ids: Iterable[str]) -> None:
        """As in `Scheduler`."""
        for some in batches(list(ids)):
            call(["qdel", *some], "PBS", harmless=_GONE)

    def version(self) -> str:
        """As in `Scheduler`."""
        return call(["qsub", "--version"], "PBS").strip()

    def partition(self, name: str | None) -> Partition | None:
        """As in `Scheduler`."""
        if name is None:
            servers = parse_records(call(["qstat", "-B", "-f"], "PBS"))
            name = next((one.attributes["default_queue"] for one in servers if "default_queue" in one.attributes), None)
        if name is None:
            return None
        for queue in parse_records(call(["qstat", "-Q", "-f", name], "PBS", harmless="Unknown queue")):
            up = all(queue.attributes.get(what) == "True" for what in ("enabled", "started"))
            limit = queue.attributes.get("resources_max.walltime", "")
            return Partition(queue.name, up, _seconds(limit), None)
        return None


def parse_records(listing: str) -> Iterator[Record]:
    """Records of `qstat -f`, whose long lines go on in lines that begin with a tab."""
    record: Record | None = None
    for line in listing.replace("\n\t", "").splitlines():
        if head := re.fullmatch(r"(?:Job Id|Queue|Server): (\S+)", line):
            if record is not None:
                yield record
            record = Record(head[1], {})
        elif record is not None and (attribute := re.fullmatch(r" {4}([\w.]+) = (.*)", line)):
            record.attributes[attribute[1]] = attribute[2]
    if record is not None:
        yield record


def parse_jobs(listing: str, mark: str) -> tuple[Job, ...]:
    """The jobs whose mark begins like this in what `qstat -f` printed."""
    jobs = []
    for id, attributes in parse_records(listing):
        variables = attributes.get("Variable_List", "")
        role = re.search(rf"(?:^|,){_MARK}={re.escape(mark)}([^,]*)", variables)
        if role is not None:
            letter = attributes.get("job_state", "")
            reason = _HELD if letter == "H" else attributes.get("comment", "None")
            state = _STATES.get(letter, "COMPLETING")
            jobs.append(Job(_number(id), attributes.get("Job_Name", ""), state, reason, role[1]))
    return tuple(jobs)


def _number(answer: str) -> str:
    lines = answer.split()
    found = re.fullmatch(r"(\d+)(\..*)?", lines[-1]) if lines else None
    if found is None:
        raise SchedulerError(f"qsub answered {answer.strip()!r}, which is no job id; was the job submitted?")
    return found[1]


def _seconds(text: str) -> int | None:
    """Seconds in "HH:MM:SS", with any number of hours; None for what is no time."""
    match = re.fullmatch(r"(\d+):(\d+):(\d+)", text)
    return int(match[1]) * 3600 + int(match[2]) * 60 + int(match[3]) if match else None


def _hours(walltime: str) -> str:
    """PBS has no days."""
    minutes, seconds = divmod(walltime_seconds(walltime), 60)
    return f"{minutes // 60:02d}:{minutes % 60:02d}:{seconds:02d}"


def _plain(path: Path) -> str:
    text = one_line(path)
    if not re.fullmatch(r"[\w./+-]*", text, re.ASCII):
        raise ValueError(f"{text}: PBS takes no folder with spaces or signs in its name; move the project")
    return text
