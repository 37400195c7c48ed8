"""Submitting a run: one small job that keeps itself in the queue until the map is made."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gaitflow.config.cluster import Profile, load_profile
from gaitflow.execute.drivers import refuse_second_driver
from gaitflow.execute.schedulers.base import Scheduler
from gaitflow.execute.schedulers.choice import record_scheduler, scheduler_of
from gaitflow.execute.schedulers.scripts import driver_script, worker_script
from gaitflow.files import atomic_write


@dataclass(frozen=True)
class Submission:
    """What is submitted for a run: the driver's script now, a worker's `profile.jobs` times by the driver."""

    run_folder: Path
    scheduler: Scheduler
    profile: Profile
    profile_file: Path
    driver: str
    worker: str


def prepare(root: Path, run_folder: Path, scenario: str, profile_file: Path, longest_unit_s: float) -> Submission:
    """The exact scripts of a run of `scenario`, a name or a whole path; nothing is written. Raises ConfigError."""
    profile = load_profile(profile_file)
    scheduler = scheduler_of(profile)
    kept = _kept_profile(run_folder), _kept_script(run_folder)
    driver = driver_script(scheduler, profile, run_folder, root, scenario, *kept)
    address = f"{'tls' if profile.tls else 'tcp'}://SCHEDULER:PORT"
    worker = worker_script(scheduler, profile, run_folder, "SESSION-NUMBER", address, longest_unit_s)
    return Submission(run_folder, scheduler, profile, profile_file, driver, worker)


def submit_run(submission: Submission) -> str:
    """Submit the driver and return its job's id.

    Raises DriverAlive when the run has a driver, SchedulerError when driver or workers are refused, WriteError.
    """
    folder, scheduler = submission.run_folder, submission.scheduler
    refuse_second_driver(folder, scheduler)
    scheduler.check(submission.worker)  # the driver would be told the same, where nobody looks
    # Copies: a requeued driver reads them again, and the file may be edited or removed meanwhile.
    atomic_write(_kept_profile(folder), submission.profile_file.read_bytes())
    atomic_write(_kept_script(folder), submission.driver.encode())
    record_scheduler(folder, scheduler)
    (folder / "logs").mkdir(exist_ok=True)
    return scheduler.submit(submission.driver)


def _kept_profile(run_folder: Path) -> Path:
    return run_folder / "cluster" / "profile.yaml"


def _kept_script(run_folder: Path) -> Path:
    return run_folder / "cluster" / "driver.sh"
