"""`gaitflow sweep`: a scenario over sampled robots."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, fail
from gaitflow.cli.options import profile_option, scenario_argument, workers_option
from gaitflow.pipeline.workspace import Workspace


@click.command()
@scenario_argument
@click.argument("sweep")
@workers_option
@profile_option
@click.pass_obj
def sweep(workspace: Workspace, scenario: str, sweep: str, workers: int, profile_file: Path | None) -> None:
    """Solve and label SCENARIO with every robot of SWEEP, whose parameters are sampled within ranges.

    SWEEP is a file of configs/sweeps, by its name or path. The run is in runs/SCENARIO-SWEEP; stop it with Ctrl-C, the
    same command goes on where it stopped.

    \b
    Example: gaitflow sweep half-cheetah-exact-effort half-cheetah --workers 2
    """
    from gaitflow.config.cluster import load_profile
    from gaitflow.dataset.collect import NotComplete
    from gaitflow.execute.drivers import DriverAlive
    from gaitflow.execute.run import RunFailed
    from gaitflow.execute.schedulers.base import SchedulerError
    from gaitflow.pipeline import sweep as stage
    from gaitflow.report.claims import SCENARIOS
    from gaitflow.report.sweep_page import share_texts, sweep_data

    with bad_input():
        resolved, given = workspace.scenario(scenario), workspace.sweep(sweep)
        try:
            profile = None if profile_file is None else load_profile(profile_file)
            labels = stage.sweep(workspace, resolved, given, workers, profile)
        except (RunFailed, NotComplete, DriverAlive, SchedulerError) as error:
            fail(str(error))
        known = share_texts(sweep_data(stage.sweep_result(workspace, given))) if resolved.name in SCENARIOS else {}
    counts = labels.loc[labels["status"] == "solved", "gait"].value_counts()
    for gait, count in counts.items():
        click.echo(f"{count:5d}  {gait}")
    for status in ("infeasible", "failed"):
        click.echo(f"{int((labels['status'] == status).sum()):5d}  {status}")
    for rule, shares in known.items():
        click.echo(f"robots that keep a statement of the paper, by {rule}:")
        for name, told in shares.items():
            click.echo(f"  {name:16} {told}")
    click.echo(workspace.sweep_run(resolved.name, given).table)
