"""Submitting a run: one small job that keeps itself in the queue until the map is made."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gaitflow.config.cluster import Profile, load_profile
from gaitflow.execute.drivers import refuse_second_driver
from gaitflow.execute.schedulers.jobs import check, submit
from gaitflow.execute.schedulers.scripts import driver_script, worker_script
from gaitflow.files import atomic_write


@dataclass(frozen=True)
class Submission:
    """What goes to Slurm for a run: the driver's script now, the worker's `profile.jobs` times by the driver."""

    run_folder: Path
    profile: Profile
    profile_file: Path
    driver: str
    worker: str


def prepare(root: Path, run_folder: Path, scenario: str, profile_file: Path, longest_unit_s: float) -> Submission:
    """The exact scripts of a run of `scenario`, a name or a whole path; nothing is written. Raises ConfigError."""
    profile = load_profile(profile_file)
    driver = driver_script(profile, run_folder, root, scenario, _kept_profile(run_folder))
    scheduler = f"{'tls' if profile.tls else 'tcp'}://SCHEDULER:PORT"
    worker = worker_script(profile, run_folder, "SESSION-NUMBER", scheduler, longest_unit_s)
    return Submission(run_folder, profile, profile_file, driver, worker)


def submit_run(submission: Submission) -> str:
    """Hand the driver to Slurm and return its job's id.

    Raises DriverAlive when the run has a driver, SlurmError when Slurm refuses driver or workers, WriteError.
    """
    folder = submission.run_folder
    refuse_second_driver(folder)
    check(submission.worker)  # the driver would be told the same, where nobody looks
    # A copy: a requeued driver reads it again, and the file may be edited or removed meanwhile.
    atomic_write(_kept_profile(folder), submission.profile_file.read_bytes())
    (folder / "logs").mkdir(exist_ok=True)
    return submit(submission.driver)


def _kept_profile(run_folder: Path) -> Path:
    return run_folder / "cluster" / "profile.yaml"
