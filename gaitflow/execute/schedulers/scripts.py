"""The exact texts of the jobs: of a worker, of the driver, of the doctor's job. Pure functions."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from gaitflow.config.cluster import Profile, lifetime
from gaitflow.execute.line_process import ONE_THREAD
from gaitflow.execute.schedulers.base import DRIVER, Request, Scheduler, job_mark, one_line
from gaitflow.execute.settings import exports
from gaitflow.execute.tls import tls_files

DEATH_TIMEOUT_S = 60  # a worker that finds no scheduler ends
DOCTOR_WALLTIME = "00:05:00"
RESTARTS = 20  # a driver that was killed goes back to the queue, but not for ever

# exec, so that the scheduler's signals reach the worker and not a shell that waits for it.
_WORKER = """\
#!/bin/bash
{header}
{environment}
{dask}
{setup}exec {command}
"""

_DOCTOR = """\
#!/bin/bash
{header}
{environment}
{setup}exec {command}
"""

# A shell that waits: also a driver that was killed without a word (out of memory) goes back to the queue.
# USR1 is sent before the end of the walltime, TERM by a cancel and by preemption, after which the scheduler requeues.
_DRIVER = """\
#!/bin/bash
{header}
{environment}
export GAITFLOW_DRIVER_JOB="{job}"
{setup}cd {root} || exit 1
stop=
child=
trap 'stop=requeue; kill -TERM "$child" 2>/dev/null' USR1
trap 'stop=end; kill -TERM "$child" 2>/dev/null' TERM
{notice}run() {{
  code=1
  if [ -z "$stop" ]; then
    "$@" &
    child=$!
    wait "$child"; code=$?
    while kill -0 "$child" 2>/dev/null; do wait "$child"; code=$?; done
  fi
  if [ -z "$stop" ] && [ "$code" -gt 128 ] && [ "{restarts}" -lt {most_restarts} ]; then stop=requeue; fi
  if [ "$stop" = requeue ]; then {requeue}; fi
  if [ -n "$stop" ] || [ "$code" -ne 0 ]; then exit "$code"; fi
}}
run {solve}
run {rest}
"""


def worker_script(
    scheduler: Scheduler,
    profile: Profile,
    run_folder: Path,
    worker: str,
    address: str,
    longest_unit_s: float,
    python: str = sys.executable,
) -> str:
    """The job of one worker of one thread, called `worker`, that serves Dask's scheduler at this address.

    It takes no new unit when one of `longest_unit_s` would no longer fit into its walltime. Raises ValueError for a
    folder that no script can name.
    """
    life, stagger = lifetime(profile, longest_unit_s)
    command = [
        *(python, "-m", "distributed.cli.dask_worker", address, "--name", worker),
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
    request = Request(
        name=f"gaitflow-{run_folder.resolve().name}-worker",
        mark=job_mark(run_folder, worker),
        log=run_folder / "logs" / "worker-{id}.log",
        messages=run_folder / "logs",
        walltime=profile.walltime,
        memory=profile.memory,
        cores=profile.cores,
        partition=profile.partition,
        account=profile.account,
        requeued=False,
        directives=profile.directives,
    )
    return _WORKER.format(
        header=scheduler.header(request),
        environment=_environment(profile),
        dask=exports(),
        setup=_lines(profile.setup),
        command=text,
    )


def driver_script(
    scheduler: Scheduler,
    profile: Profile,
    run_folder: Path,
    root: Path,
    scenario: str,
    profile_file: Path,
    script_file: Path,
    python: str = sys.executable,
) -> str:
    """The job that runs the workflow of `scenario` in the workspace `root`: solve in jobs, then all other stages.

    Stopped before its walltime, preempted, lost with its node or killed, it goes back to the queue and then goes on
    from the store. `script_file` is where this text is kept. Raises ValueError for a folder that no script can name.
    """
    cli = [python, "-m", "gaitflow.cli", "--root", str(root.resolve())]
    driver = profile.driver
    request = Request(
        name=f"gaitflow-{run_folder.resolve().name}-driver",
        mark=job_mark(run_folder, DRIVER),
        log=run_folder / "logs" / "driver-{id}.log",
        messages=run_folder / "logs",
        walltime=driver.walltime,
        memory=driver.memory,
        cores=1,
        partition=driver.partition or profile.partition,
        account=profile.account,
        requeued=True,
        directives=profile.directives if driver.directives is None else driver.directives,
    )
    shell = scheduler.driver_shell(driver.walltime_s, script_file)
    return _DRIVER.format(
        header=scheduler.header(request),
        environment=_environment(profile),
        setup=_lines(profile.setup),
        root=shlex.quote(one_line(root)),
        job=shell.job,
        notice=shell.notice,
        restarts=shell.restarts,
        most_restarts=RESTARTS,
        requeue=shell.requeue,
        solve=shlex.join([*cli, "solve", scenario, "--profile", str(profile_file.resolve())]),
        rest=shlex.join([*cli, "run", scenario, "--workers", "1"]),
    )


def doctor_script(scheduler: Scheduler, profile: Profile, folder: Path, python: str = sys.executable) -> str:
    """The small job of `gaitflow doctor`: like a worker's, and what it finds goes into `folder`."""
    request = Request(
        name="gaitflow-doctor",
        mark=job_mark(folder, "doctor"),
        log=folder / "log",
        messages=None,
        walltime=DOCTOR_WALLTIME,
        memory=profile.memory,
        cores=profile.cores,
        partition=profile.partition,
        account=profile.account,
        requeued=False,
        directives=profile.directives,
    )
    command = [python, "-m", "gaitflow.execute.doctor_node", str(folder.resolve())]
    scratch = f' --scratch "{profile.scratch}"' if profile.scratch else ""
    return _DOCTOR.format(
        header=scheduler.header(request),
        environment=_environment(profile),
        setup=_lines(profile.setup),
        command=shlex.join(command) + scratch,
    )


def _environment(profile: Profile) -> str:
    lines = [f"export {name}={value}" for name, value in ONE_THREAD.items()]
    if profile.scratch:
        lines.append(f'export TMPDIR="{profile.scratch}"')
    return "\n".join(lines)


def _lines(lines: tuple[str, ...]) -> str:
    return "".join(f"{line}\n" for line in lines)
