"""Which scheduler a profile names, and which one a run has its jobs in."""

from __future__ import annotations

from pathlib import Path

from gaitflow.config.cluster import Profile
from gaitflow.execute.schedulers.base import Scheduler
from gaitflow.execute.schedulers.pbs import Pbs
from gaitflow.execute.schedulers.slurm import Slurm
from gaitflow.files import atomic_write

_SCHEDULERS: tuple[Scheduler, ...] = (Slurm(), Pbs())


def scheduler_of(profile: Profile) -> Scheduler:
    """The scheduler that this profile is for."""
    return next(one for one in _SCHEDULERS if one.name == profile.scheduler)


def record_scheduler(run_folder: Path, scheduler: Scheduler) -> None:
    """Keep in the run's folder where its jobs are, for commands that are given no profile. Raises WriteError."""
    atomic_write(_record(run_folder), scheduler.name.encode())


def recorded_scheduler(run_folder: Path) -> Scheduler:
    """The scheduler that the run's folder names; Slurm when it names none, as folders of earlier versions do."""
    try:
        name = _record(run_folder).read_text()
    except (OSError, ValueError):
        name = ""
    return next((one for one in _SCHEDULERS if one.name == name), _SCHEDULERS[0])


def _record(run_folder: Path) -> Path:
    return run_folder / "cluster" / "scheduler"
