"""A stand-in for PBS: qsub, qselect, qstat and qdel over a folder, whose jobs are processes of this machine.

    install(folder)      # makes folder/bin with the commands; put it at the front of PATH

It was written from PBS's manuals and does what gaitflow relies on: directives, `-v`, ids with a server's name, records
with folded lines, an environment that is not the caller's, the end of a walltime, TERM and then KILL. A file
`folder/hold` keeps new jobs waiting until it is removed, and `folder/refuse` is what qsub says instead of an id.
"""

from __future__ import annotations

import fcntl
import getpass
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

SERVER = "stand-in.example.org"
COMMANDS = ("qsub", "qselect", "qstat", "qdel")
KILL_DELAY_S = 10.0
POLL_S = 0.1
LINE = 78
OPTIONS = {"-N", "-v", "-S", "-j", "-o", "-l", "-q", "-A", "-r", "-W", "-m", "-M", "-P", "-p"}
QUEUE = ["queue_type = Execution", "resources_max.walltime = 72:00:00", "enabled = True", "started = True"]


def install(folder: Path) -> Path:
    """Make the commands; the folder that has to be on PATH."""
    bin = folder / "bin"
    bin.mkdir(parents=True)
    (folder / "jobs").mkdir()
    for name in COMMANDS:
        (bin / name).write_text(f'#!/bin/bash\nexec {sys.executable} {__file__} {folder} {name} "$@"\n')
        (bin / name).chmod(0o755)
    return bin


def jobs(folder: Path) -> dict[str, dict[str, Any]]:
    """All jobs that were ever submitted, by number; the state of those that ended is "F"."""
    files = sorted((folder / "jobs").glob("*.json"), key=lambda file: int(file.stem))
    return {file.stem: json.loads(file.read_text()) for file in files}


def _change(folder: Path, number: str, **values: Any) -> dict[str, Any]:
    file = folder / "jobs" / f"{number}.json"
    with open(folder / "lock", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        job: dict[str, Any] = (json.loads(file.read_text()) if file.exists() else {}) | values
        new = file.with_suffix(".new")
        new.write_text(json.dumps(job))
        new.rename(file)
    return job


def qsub(folder: Path, arguments: Sequence[str]) -> str:
    if list(arguments) == ["--version"]:
        return "pbs_version = stand-in"
    if (folder / "refuse").exists():
        sys.exit(f"qsub: {(folder / 'refuse').read_text().strip()}")
    *given, script = [*arguments] if len(arguments) % 2 else [*arguments, "-"]
    text = sys.stdin.read() if script == "-" else Path(script).read_text()
    lines = [line.removeprefix("#PBS ") for line in text.splitlines() if line.startswith("#PBS ")]
    options: dict[str, str] = {}
    resources: dict[str, str] = {}
    for option, value in [*(line.split(" ", 1) for line in lines), *zip(given[::2], given[1::2], strict=True)]:
        if option not in OPTIONS:
            sys.exit(f"qsub: invalid option -- '{option}'")
        options[option] = value  # what the command says comes last, and stands instead of the script's
        if option == "-l":
            resources |= dict([value.split("=", 1)])
    if not re.fullmatch(r"select=1:ncpus=\d+:mem=\d+[kmgt]b", f"select={resources.get('select')}"):
        sys.exit("qsub: Illegal attribute or resource value Resource_List.select")
    with open(folder / "lock", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        number = str(len(list((folder / "jobs").glob("*.sh"))) + 1)
        (folder / "jobs" / f"{number}.sh").write_text(text)
    _change(folder, number, options=options, resources=resources, state="Q", pid=None)
    with open(folder / f"{number}.err", "ab") as log:
        subprocess.Popen(
            [sys.executable, __file__, str(folder), "run", number],
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )
    return f"{number}.{SERVER}"


def run(folder: Path, arguments: Sequence[str]) -> str:
    """What a node does with a job."""
    (number,) = arguments
    while (folder / "hold").exists():
        if jobs(folder)[number]["state"] == "F":
            return ""
        time.sleep(POLL_S)
    job = jobs(folder)[number]
    hours, minutes, seconds = map(int, job["resources"]["walltime"].split(":"))
    inherited = {name: os.environ[name] for name in ("PATH", "HOME", "PYTHONPATH") if name in os.environ}
    variables = dict(pair.split("=", 1) for pair in job["options"].get("-v", "").split(","))
    path = Path(job["options"]["-o"])
    output = path / f"{job['options']['-N']}.o{number}" if path.is_dir() else path
    with open(output, "ab") as file:
        process = subprocess.Popen(
            [job["options"]["-S"], str(folder / "jobs" / f"{number}.sh")],
            env=inherited | variables | {"PBS_JOBID": f"{number}.{SERVER}", "TMPDIR": "/tmp"},
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=file,
        )
        _change(folder, number, state="R", pid=process.pid)
        try:
            code = process.wait(timeout=hours * 3600 + minutes * 60 + seconds)
        except subprocess.TimeoutExpired:
            file.write(b"=>> PBS: job killed: walltime exceeded limit\n")
            _end(process.pid)
            code = process.wait()
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)  # nothing of a job stays on its node
    _change(folder, number, state="F", code=code)
    return ""


def qselect(folder: Path, arguments: Sequence[str]) -> str:
    assert list(arguments) == ["-u", getpass.getuser()], arguments
    return "\n".join(f"{number}.{SERVER}" for number, job in jobs(folder).items() if job["state"] != "F")


def qstat(folder: Path, arguments: Sequence[str]) -> str:
    if list(arguments) == ["-B", "-f"]:
        return f"Server: {SERVER}\n    server_state = Active\n    default_queue = workq"
    if list(arguments[:2]) == ["-Q", "-f"]:
        if arguments[2] != "workq":
            sys.exit(f"qstat: Unknown queue {arguments[2]}")
        return "\n    ".join(["Queue: workq", *QUEUE])
    assert arguments[0] == "-f", arguments
    known, records, unknown = jobs(folder), [], []
    for id in arguments[1:]:
        job = known.get(id.partition(".")[0])
        if job is None:
            unknown.append(f"qstat: Unknown Job Id {id}")
        elif job["state"] == "F":
            unknown.append(f"qstat: {id} Job has finished, use -x or -H to obtain historical job information")
        else:
            records.append(_record(id, job))
    return _with_errors("\n\n".join(records), unknown)


def qdel(folder: Path, arguments: Sequence[str]) -> str:
    known, faults = jobs(folder), []
    for id in arguments:
        number = id.partition(".")[0]
        job = known.get(number)
        if job is None or job["state"] == "F":
            faults.append(f"qdel: {'Unknown Job Id' if job is None else 'Job has finished'} {id}")
        elif job["state"] == "Q":
            _change(folder, number, state="F", code=None)
        else:
            subprocess.Popen([sys.executable, __file__, str(folder), "end", str(job["pid"])], start_new_session=True)
    return _with_errors("", faults)


def _end(pid: int) -> None:
    """TERM to all processes of the job, and KILL later."""
    with suppress(ProcessLookupError):
        os.killpg(pid, signal.SIGTERM)
        deadline = time.monotonic() + KILL_DELAY_S
        while time.monotonic() < deadline:
            os.killpg(pid, 0)
            time.sleep(POLL_S)
        os.killpg(pid, signal.SIGKILL)


def _record(id: str, job: dict[str, Any]) -> str:
    options, resources = job["options"], job["resources"]
    variables = ["PBS_O_HOME=/users/anna", "PBS_O_LANG=C", f"PBS_O_PATH={'/opt/some/where/bin:' * 6}", options["-v"]]
    attributes = [
        f"Job_Name = {options['-N']}",
        f"job_state = {job['state']}",
        f"queue = {options.get('-q', 'workq')}",
        *(f"Resource_List.{name} = {value}" for name, value in resources.items()),
        f"Variable_List = {','.join(variables)},PBS_O_HOST=login1",
        *(["comment = Not Running: Not enough free nodes"] if job["state"] == "Q" else []),
    ]
    return "\n".join([f"Job Id: {id}", *(_folded(f"    {attribute}") for attribute in attributes)])


def _folded(line: str) -> str:
    pieces = [line[start : start + LINE] for start in range(0, len(line), LINE)]
    return "\n\t".join(pieces)


def _with_errors(text: str, errors: list[str]) -> str:
    if errors:
        print(text, flush=True)
        sys.exit("\n".join(errors))
    return text


def main() -> None:
    folder, command, arguments = Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    with open(folder / "calls", "a") as calls:
        calls.write(shlex.join([command, *arguments]) + "\n")
    if command == "end":
        return _end(int(arguments[0]))
    answer = {"qsub": qsub, "qselect": qselect, "qstat": qstat, "qdel": qdel, "run": run}[command](folder, arguments)
    if answer:
        print(answer)


if __name__ == "__main__":
    main()
