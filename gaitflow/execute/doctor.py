"""Whether a cluster can do what a run needs, tried out with one tiny job: `gaitflow doctor`."""

from __future__ import annotations

import json
import secrets
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gaitflow.config.cluster import Profile
from gaitflow.execute import doctor_node
from gaitflow.execute.schedulers.base import Partition, Scheduler, SchedulerError
from gaitflow.execute.schedulers.choice import scheduler_of
from gaitflow.execute.schedulers.jobs import Queue
from gaitflow.execute.schedulers.scripts import doctor_script
from gaitflow.files import WriteError, publish_once

POLL_S = 0.5
SETTLE_S = 20.0  # after its job has ended, a file may take this long to be seen on a network file system
CLOCK_LIMIT_S = 10.0
LAST_LINES = 3


@dataclass(frozen=True)
class Finding:
    """One check: what was looked at, whether it is fine, and what was found or what to do."""

    check: str
    ok: bool
    text: str


def examine(profile: Profile, runs: Path, wait_s: float) -> Iterator[Finding]:
    """All checks, each as soon as it is done; those that cannot be made after a fault are left out.

    `runs` is the folder of the runs, which all nodes have to see. A job that does not start within `wait_s` is a fault.
    """
    scheduler = scheduler_of(profile)
    try:
        yield Finding(scheduler.submit_command, True, scheduler.version())
        driver = profile.driver
        workers = _partition(scheduler, "workers", profile.partition, profile.walltime_s)
        yield workers
        yield _partition(scheduler, "driver", driver.partition or profile.partition, driver.walltime_s)
    except SchedulerError as error:
        yield Finding(scheduler.submit_command, False, str(error))
        return
    if not workers.ok:
        return
    folder = runs.resolve() / f".doctor-{secrets.token_hex(4)}"
    try:
        publish_once(folder / doctor_node.TAKEN, b"here")
        yield from _job(scheduler, profile, folder, wait_s)
    except SchedulerError as error:
        yield Finding("job", False, f"{error}; check account, memory and directives of {profile.name}")
    except WriteError as error:
        yield Finding("shared folder", False, str(error))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _partition(scheduler: Scheduler, role: str, name: str | None, walltime_s: int) -> Finding:
    check = f"partition of the {role}"
    found = scheduler.partition(name)
    called = found.name if found else str(name or "the default one")
    if found is None:
        return Finding(
            check, False, f"{called}: no such partition; `{scheduler.partitions_command}` lists those there are"
        )
    if not found.up:
        return Finding(check, False, f"{called} is down; choose another one, or ask its administrators")
    if found.limit_s is not None and walltime_s > found.limit_s:
        return Finding(check, False, f"{called} allows {found.limit_s} s, the walltime is {walltime_s} s; shorten it")
    return Finding(check, True, _described(found))


def _described(found: Partition) -> str:
    limit = "no limit of time" if found.limit_s is None else f"at most {found.limit_s / 3600:g} h"
    nodes = "" if found.nodes is None else f"{found.nodes} nodes, "
    return f"{found.name}: {nodes}{limit}"


def _job(scheduler: Scheduler, profile: Profile, folder: Path, wait_s: float) -> Iterator[Finding]:
    before = time.time()
    job = scheduler.submit(doctor_script(scheduler, profile, folder))
    try:
        ended = _wait_for(folder / doctor_node.REPORT, folder, scheduler, job, wait_s)
        yield Finding("job", ended is None, ended or f"job {job} started within {time.time() - before:.0f} s")
        if ended is not None:
            return
        report = json.loads((folder / doctor_node.REPORT).read_bytes())
        yield Finding("shared folder", True, f"{folder.parent} is seen by {report['host']}")
        yield _links(folder, report)
        yield _clock(folder, scheduler, job)
        yield _environment(report)
        yield _scratch(profile, report)
        if profile.interface:
            yield _interface(profile.interface, report)
    finally:
        scheduler.cancel([job])


def _wait_for(path: Path, folder: Path, scheduler: Scheduler, job: str, wait_s: float) -> str | None:
    """Wait for a file that the job writes; what went wrong when it does not come, None when it is here."""
    queue, deadline = Queue(folder, scheduler), time.monotonic() + wait_s
    state, gone_by = "submitted", float("inf")
    while not path.exists():
        news = queue.news()
        if news is not None:
            mine = [one for one in news[0] if one.id == job and one.alive]
            state = f"{mine[0].state.lower()} ({mine[0].reason})" if mine else "gone"
            if not mine:
                gone_by = min(gone_by, time.monotonic() + SETTLE_S)
        if time.monotonic() > gone_by:
            log = _log(folder)
            said = f"it said: {log}" if log else f"nothing that it wrote can be seen in {folder.parent}"
            return (
                f"job {job} ended without a report; {said}; the environment and the folder have to be on a file "
                "system that all nodes share, and `setup` has to prepare the node's shell"
            )
        if time.monotonic() > deadline and state != "gone":
            return f"job {job} is {state} after {wait_s:.0f} s; wait longer with --wait, or choose another partition"
        time.sleep(POLL_S)
    return None


def _log(folder: Path) -> str:
    try:
        return " / ".join((folder / "log").read_text(errors="replace").strip().splitlines()[-LAST_LINES:])
    except OSError:
        return ""


def _links(folder: Path, report: dict[str, Any]) -> Finding:
    if report["took_taken_name"] or publish_once(folder / doctor_node.REPORT, b"here"):
        return Finding(
            "atomic link",
            False,
            f"{folder.parent}: node and login node both gave a file one name; a unit could be stored twice, "
            "choose another file system",
        )
    return Finding("atomic link", True, "the first file of a name stays, here and on the node")


def _clock(folder: Path, scheduler: Scheduler, job: str) -> Finding:
    asked = time.time()
    publish_once(folder / doctor_node.QUESTION, b"")
    fault = _wait_for(folder / doctor_node.ANSWER, folder, scheduler, job, doctor_node.WAIT_S)
    if fault is not None:
        return Finding("clock", False, fault)
    answered, there = time.time(), float(json.loads((folder / doctor_node.ANSWER).read_bytes())["time"])
    apart = max(asked - there, there - answered, 0.0)
    if apart > CLOCK_LIMIT_S:
        return Finding("clock", False, f"node and login node are {apart:.0f} s apart; ask for a time service")
    return Finding("clock", True, f"less than {max(apart, answered - asked):.1f} s apart")


def _environment(report: dict[str, Any]) -> Finding:
    here = doctor_node.environment()
    if report["import_fault"]:
        return Finding("Python", False, f"on {report['host']}: {report['import_fault']}; see `setup` in the profile")
    for what in ("gaitflow", "python", "solver"):
        if report[what] != here[what]:
            return Finding("Python", False, f"{what} is {report[what]} on the node and {here[what]} here; use one")
    return Finding("Python", True, f"gaitflow {report['gaitflow']}, CasADi {report['solver']['casadi']} on the node")


def _scratch(profile: Profile, report: dict[str, Any]) -> Finding:
    where = profile.scratch or "folder for temporary files"
    if report["scratch"]:
        return Finding("scratch", False, f"{where}: {report['scratch']}; name another folder in `scratch`")
    return Finding("scratch", True, f"{where} can be written")


def _interface(name: str, report: dict[str, Any]) -> Finding:
    if name in report["interfaces"]:
        return Finding("interface", True, f"{name} is there")
    there = ", ".join(report["interfaces"])
    return Finding(
        "interface", False, f"{name}: {report['host']} has no such interface, but {there}; correct `interface`"
    )
