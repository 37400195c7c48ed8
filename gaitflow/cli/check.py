"""What a run, a scenario or a published folder is: status, validate, verify."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, print_json, warn_of_training
from gaitflow.cli.options import PUBLISHED, json_option, scenario_argument
from gaitflow.pipeline import published, stages
from gaitflow.pipeline.sweep import sweep_status
from gaitflow.pipeline.workspace import Workspace


@click.command()
@scenario_argument
@click.option("--sweep", help="Of SCENARIO's run with this sweep instead, with all its robots.")
@json_option
@click.pass_obj
def status(workspace: Workspace, scenario: str, sweep: str | None, as_json: bool) -> None:
    """Say how far the run of SCENARIO is.

    It works while the run is on, after it, and on another machine that sees the folder.

    \b
    Example: gaitflow status quickstart --json
             gaitflow status half-cheetah-exact-effort --sweep half-cheetah
    """
    from gaitflow.execute.status import run_status
    from gaitflow.pipeline.sampling import chosen_tasks
    from gaitflow.store.parts import UnitStore

    with bad_input():
        resolved = workspace.scenario(scenario)
        if sweep is None:
            run = workspace.run(resolved)
            chosen = chosen_tasks(run, resolved) if resolved.tasks.adaptive else None
            state = run_status(resolved, UnitStore(run.folder), chosen)
        else:
            state = sweep_status(workspace, resolved, workspace.sweep(sweep))
    if as_json:
        return print_json(state.as_data())
    left = "unknown" if state.cpu_hours_left is None else f"{state.cpu_hours_left:.3f}"
    click.echo(
        f"{state.scenario}: {state.units} units: {state.solved} solved, {state.failed} failed, {state.left} left"
    )
    click.echo(f"solves: {state.solves}, with those in {state.begun} units that are begun and not finished")
    click.echo(f"driver: {state.driver or 'none; nothing is being solved'}")
    click.echo(f"CPU hours: {state.cpu_hours_spent:.3f} spent, {left} left; {state.quarantined} files in quarantine")
    if state.jobs is not None:
        click.echo(f"jobs: {state.jobs}")
    if state.logs is not None:
        click.echo(f"logs: {state.logs}")
    for attempt in state.errors:
        click.echo(f"  {attempt}")


@click.command()
@scenario_argument
@json_option
@click.pass_obj
def validate(workspace: Workspace, scenario: str, as_json: bool) -> None:
    """Check the file of SCENARIO and say what it asks for.

    Also says how many solves it needs, and about how long they take.

    \b
    Example: gaitflow validate configs/scenarios/quickstart.yaml
    """
    from gaitflow.pipeline.forecast import forecast

    with bad_input():
        resolved = workspace.scenario(scenario)
        data = stages.summary(resolved)
        work = forecast(resolved)
        warn_of_training(resolved)
    if as_json:
        return print_json(data | asdict(work))
    for key, value in data.items():
        click.echo(f"{key.replace('_', ' '):16} {value}")
    click.echo(f"{'solves':16} about {work.solves}")
    if work.cpu_hours is not None:
        hours = f"{work.cpu_hours:.2g}"
        click.echo(
            f"{'CPU hours':16} about {hours}, on cores like this one; `gaitflow estimate {scenario}` measures them"
        )


@click.command()
@click.argument("path", type=PUBLISHED)
@json_option
def verify(path: Path, as_json: bool) -> None:
    """Check a published map or dataset.

    PATH is the folder of a version. All of it is checked: digests, contents and motions.

    \b
    Example: gaitflow verify models/quickstart/1.0.0
    """
    with bad_input():
        faults = published.verify(path)
    if as_json:
        print_json({"path": str(path), "sound": not faults, "faults": faults})
    else:
        for fault in faults:
            click.echo(fault)
        click.echo(f"{path}: {f'{len(faults)} fault(s)' if faults else 'sound'}")
    if faults:
        sys.exit(1)
