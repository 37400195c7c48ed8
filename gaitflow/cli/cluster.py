"""`gaitflow submit`, `cancel` and `doctor`: runs on a cluster."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, fail, print_json
from gaitflow.cli.options import found_profile, json_option
from gaitflow.pipeline.workspace import Workspace, from_anywhere

profile_option = click.option(
    "--profile",
    "profile_file",
    required=True,
    callback=found_profile,
    help="The profile of the cluster: its file, or the name of one that ships.",
)


@click.command()
@click.argument("scenario")
@profile_option
@click.option("--dry-run", is_flag=True, help="Print the scripts that would be submitted, and submit nothing.")
@json_option
@click.pass_obj
def submit(workspace: Workspace, scenario: str, profile_file: Path, dry_run: bool, as_json: bool) -> None:
    """Make the map of SCENARIO on a cluster.

    This submits a driver job, which keeps its workers in the queue. You may log out; `gaitflow status` says how far
    the run is. Whatever ends the driver or its workers, what is solved is kept, and another `submit` goes on from
    there.

    \b
    Example: gaitflow submit quickstart --profile slurm/profiles/centre-48h.yaml --dry-run
    """
    from gaitflow.execute.solver import longest_unit_s
    from gaitflow.execute.status import run_status
    from gaitflow.execute.submit import prepare, submit_run
    from gaitflow.learn.installed import check_installed
    from gaitflow.store.parts import UnitStore
    from gaitflow.store.units import plan_units

    with bad_input(), _scheduler_errors():
        resolved = workspace.scenario(scenario)
        check_installed(resolved.learning)
        folder = workspace.run(resolved).folder
        longest = longest_unit_s(plan_units(resolved))
        submission = prepare(workspace.root, folder, from_anywhere(scenario), profile_file, longest)
        hours = run_status(resolved, UnitStore(folder)).cpu_hours_left
        job = None if dry_run else submit_run(submission)
    scripts = {"driver": submission.driver, "worker": submission.worker, "workers": submission.profile.jobs}
    if as_json:
        said = {"scenario": resolved.name, "job": job, "logs": str(folder / "logs"), "cpu_hours_left": hours}
        return print_json(said | scripts)
    left = f"`gaitflow estimate {scenario}` tells" if hours is None else f"{hours:.3g}, on cores as those before"
    if job is None:
        click.echo(f"# CPU hours left: {left}")
        click.echo(f"# driver: 1 job\n{submission.driver}")
        click.echo(f"# workers: {submission.profile.jobs} jobs, submitted by the driver\n{submission.worker}", nl=False)
        return
    click.echo(f"{resolved.name}: driver job {job}, up to {submission.profile.jobs} workers; logs in {folder / 'logs'}")
    click.echo(f"CPU hours left: {left}")
    click.echo(f"watch it with `gaitflow status {scenario}`, end it with `gaitflow cancel {scenario}`")


@click.command()
@click.argument("scenario")
@json_option
@click.pass_obj
def cancel(workspace: Workspace, scenario: str, as_json: bool) -> None:
    """End all jobs of the run of SCENARIO, and no others.

    What is solved is kept.

    \b
    Example: gaitflow cancel quickstart
    """
    from gaitflow.execute.drivers import driver_process
    from gaitflow.execute.schedulers.choice import recorded_scheduler
    from gaitflow.execute.schedulers.jobs import cancel_run

    with bad_input(), _scheduler_errors():
        resolved = workspace.scenario(scenario)
        folder = workspace.run(resolved).folder
        jobs = cancel_run(folder, recorded_scheduler(folder))
    process = driver_process(folder)
    if as_json:
        return print_json({"scenario": resolved.name, "cancelled": [asdict(job) for job in jobs], "process": process})
    for job in jobs:
        click.echo(f"cancelled {job.id} {job.name}, which was {job.state.lower()}")
    click.echo(f"{resolved.name}: {len(jobs)} jobs cancelled")
    if process is not None:
        click.echo(f"{process} still drives this run and will submit workers again; end it with Ctrl-C there")


@click.command()
@profile_option
@click.option(
    "--wait", default=600.0, show_default=True, type=click.FloatRange(1), help="How long the job may take to start [s]."
)
@json_option
@click.pass_obj
def doctor(workspace: Workspace, profile_file: Path, wait: float, as_json: bool) -> None:
    """Check with one tiny job whether a cluster can do what a run needs.

    Each fault is one line that also says what to do.

    \b
    Example: gaitflow doctor --profile slurm/profiles/centre-48h.yaml
    """
    from gaitflow.config.cluster import load_profile
    from gaitflow.execute.doctor import examine

    found = []
    with bad_input(), _scheduler_errors():
        profile = load_profile(profile_file)
        for finding in examine(profile, workspace.root / "runs", wait):
            found.append(finding)
            if not as_json:
                click.echo(f"{'ok   ' if finding.ok else 'WRONG'} {finding.check}: {finding.text}")
    sound = all(finding.ok for finding in found)
    if as_json:
        print_json({"profile": profile.name, "sound": sound, "findings": [asdict(finding) for finding in found]})
    if not sound:
        sys.exit(1)


@contextmanager
def _scheduler_errors() -> Iterator[None]:
    from gaitflow.execute.drivers import DriverAlive
    from gaitflow.execute.schedulers.base import SchedulerError

    try:
        yield
    except (SchedulerError, DriverAlive) as error:
        fail(str(error))
