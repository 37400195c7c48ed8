"""The exact texts that are handed to sbatch: of a worker, of the driver, of the doctor's job. Pure functions."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path

from gaitflow.config.cluster import Profile, lifetime
from gaitflow.execute.line_process import ONE_THREAD
from gaitflow.execute.schedulers.jobs import DRIVER, comment
from gaitflow.execute.settings import exports
from gaitflow.execute.tls import tls_files

DEATH_TIMEOUT_S = 60  # a worker that finds no scheduler ends
NOTICE_S = 60  # before the end of its walltime the driver is told to stop
DOCTOR_WALLTIME = "00:05:00"
RESTARTS = 20  # a driver that was killed goes back to the queue, but not for ever

# exec, so that Slurm's signals reach the worker and not a shell that waits for it.
_WORKER = """\
#!/bin/bash
{directives}
{environment}
{dask}
{setup}exec {command}
"""

_DOCTOR = """\
#!/bin/bash
{directives}
{environment}
{setup}exec {command}
"""

# A shell that waits: also a driver that was killed without a word (out of memory) goes back to the queue.
# USR1 is sent before the end of the walltime, TERM by scancel and preemption, after which Slurm itself requeues.
_DRIVER = """\
#!/bin/bash
{directives}
{environment}
export GAITFLOW_DRIVER_JOB="$SLURM_JOB_ID"
{setup}cd {root} || exit 1
stop=
child=
trap 'stop=requeue; kill -TERM "$child" 2>/dev/null' USR1
trap 'stop=end; kill -TERM "$child" 2>/dev/null' TERM
run() {{
  code=1
  if [ -z "$stop" ]; then
    "$@" &
    child=$!
    wait "$child"; code=$?
    while kill -0 "$child" 2>/dev/null; do wait "$child"; code=$?; done
  fi
  if [ -z "$stop" ] && [ "$code" -gt 128 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt {restarts} ]; then stop=requeue; fi
  if [ "$stop" = requeue ]; then scontrol requeue "$SLURM_JOB_ID"; fi
  if [ -n "$stop" ] || [ "$code" -ne 0 ]; then exit "$code"; fi
}}
run {solve}
run {rest}
"""


def worker_script(
    profile: Profile, run_folder: Path, worker: str, scheduler: str, longest_unit_s: float, python: str = sys.executable
) -> str:
    """The job of one worker of one thread, called `worker`, that serves the scheduler at this address.

    It takes no new unit when one of `longest_unit_s` would no longer fit into its walltime. Raises ValueError for a
    folder that no script can name.
    """
    life, stagger = lifetime(profile, longest_unit_s)
    command = [
        *(python, "-m", "distributed.cli.dask_worker", scheduler, "--name", worker),
        *("--nthreads", "1", "--no-nanny", "--memory-limit", "0"),
        *("--no-dashboard", "--dashboard-address", "127.0.0.1:0"),
        *("--death-timeout", f"{DEATH_TIMEOUT_S}s", "--lifetime", f"{life:.0f}s"),
        *("--lifetime-stagger", f"{stagger:.0f}s", "--worker-class", "gaitflow.execute.drain.DrainingWorker"),
    ]
    if profile.interface:
        command += ["--interface", profile.interface]
    if profile.tls:
        certificate, key = map(str, tls_files(run_folder))
        command += ["--protocol", "tls", "--tls-ca-file", certificate, "--tls-cert", certificate, "--tls-key", key]
    text = shlex.join(command)
    if profile.scratch:
        text += f' --local-directory "{profile.scratch}"'  # a variable of the node is for the node to fill in
    directives = [
        *_marks(f"{run_folder.resolve().name}-worker", run_folder, worker, run_folder / "logs" / "worker-%j.log"),
        *_resources(profile, profile.walltime, profile.memory, profile.cores, profile.partition),
        "--no-requeue",
        *profile.directives,
    ]
    return _WORKER.format(
        directives="\n".join(f"#SBATCH {line}" for line in directives),
        environment=_environment(profile),
        dask=exports(),
        setup=_lines(profile.setup),
        command=text,
    )


def driver_script(
    profile: Profile, run_folder: Path, root: Path, scenario: str, profile_file: Path, python: str = sys.executable
) -> str:
    """The job that runs the workflow of `scenario` in the workspace `root`: solve on Slurm, then all other stages.

    Stopped before its walltime, preempted, lost with its node or killed, it goes back to the queue and then goes on
    from the store. Raises ValueError for a folder that no script can name.
    """
    cli = [python, "-m", "gaitflow.cli", "--root", str(root.resolve())]
    driver = profile.driver
    directives = [
        *_marks(f"{run_folder.resolve().name}-driver", run_folder, DRIVER, run_folder / "logs" / "driver-%j.log"),
        *_resources(profile, driver.walltime, driver.memory, 1, driver.partition or profile.partition),
        "--requeue",
        f"--signal=B:USR1@{NOTICE_S}",
        *(profile.directives if driver.directives is None else driver.directives),
    ]
    return _DRIVER.format(
        directives="\n".join(f"#SBATCH {line}" for line in directives),
        environment=_environment(profile),
        setup=_lines(profile.setup),
        root=shlex.quote(_one_line(str(root.resolve()))),
        restarts=RESTARTS,
        solve=shlex.join([*cli, "solve", scenario, "--profile", str(profile_file.resolve())]),
        rest=shlex.join([*cli, "run", scenario, "--workers", "1"]),
    )


def doctor_script(profile: Profile, folder: Path, python: str = sys.executable) -> str:
    """The small job of `gaitflow doctor`: like a worker's, and what it finds goes into `folder`."""
    directives = [
        *_marks("doctor", folder, "doctor", folder / "log"),
        *_resources(profile, DOCTOR_WALLTIME, profile.memory, profile.cores, profile.partition),
        "--no-requeue",
        *profile.directives,
    ]
    command = [python, "-m", "gaitflow.execute.doctor_node", str(folder.resolve())]
    scratch = f' --scratch "{profile.scratch}"' if profile.scratch else ""
    return _DOCTOR.format(
        directives="\n".join(f"#SBATCH {line}" for line in directives),
        environment=_environment(profile),
        setup=_lines(profile.setup),
        command=shlex.join(command) + scratch,
    )


def _marks(name: str, run_folder: Path, role: str, log: Path) -> list[str]:
    """How the job is called, marked as one of this run, and where its output goes; %j in `log` is the job's id."""
    folder = _one_line(str(log.parent.resolve())).replace("%", "%%")
    return [
        f"--job-name=gaitflow-{name}",
        f"--comment={comment(run_folder, role)}",
        f"--output={_quoted(f'{folder}/{log.name}')}",
        "--open-mode=append",
    ]


def _resources(profile: Profile, walltime: str, memory: str, cores: int, partition: str | None) -> list[str]:
    lines = [f"--time={walltime}", f"--mem={memory.removesuffix('B')}"]
    lines += ["--nodes=1", "--ntasks=1", f"--cpus-per-task={cores}"]
    lines += [f"--partition={partition}"] if partition else []
    return lines + ([f"--account={profile.account}"] if profile.account else [])


def _environment(profile: Profile) -> str:
    lines = [f"export {name}={value}" for name, value in ONE_THREAD.items()]
    if profile.scratch:
        lines.append(f'export TMPDIR="{profile.scratch}"')
    return "\n".join(lines)


def _lines(lines: tuple[str, ...]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _quoted(text: str) -> str:
    """As sbatch reads its own lines: words, quotes, backslashes."""
    return text if re.fullmatch(r"[\w./%@+=:,-]*", text, re.ASCII) else '"' + re.sub(r'(["\\])', r"\\\1", text) + '"'


def _one_line(path: str) -> str:
    if not path.isprintable():
        raise ValueError(f"{path!r}: cannot be named in a script of Slurm's; move the project to another folder")
    return path
