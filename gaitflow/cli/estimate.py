"""`gaitflow estimate`: how many CPU hours a map will take."""

from __future__ import annotations

import click

from gaitflow.cli.errors import bad_input, fail, print_json
from gaitflow.cli.options import json_option, scenario_argument, workers_option
from gaitflow.pipeline.workspace import Workspace


@click.command()
@scenario_argument
@click.option("--units", default=4, show_default=True, type=click.IntRange(1), help="How many units to solve.")
@workers_option
@json_option
@click.pass_obj
def estimate(workspace: Workspace, scenario: str, units: int, workers: int, as_json: bool) -> None:
    """Say how many CPU hours the map of SCENARIO will take.

    Some of its units, spread over the tasks, are solved on this machine. They are stored, so they are not solved again
    when the map is made.

    \b
    Example: gaitflow estimate quickstart --units 4
    """
    from gaitflow.execute.drivers import DriverAlive
    from gaitflow.execute.run import RunFailed
    from gaitflow.pipeline.estimate import estimate as solve_some

    with bad_input():
        resolved = workspace.scenario(scenario)
        try:
            state = solve_some(workspace, resolved, units, workers)
        except (RunFailed, DriverAlive) as error:
            fail(str(error))
    if as_json:
        return print_json(state.as_data())
    left = "unknown" if state.cpu_hours_left is None else f"{state.cpu_hours_left:.3g}"
    click.echo(
        f"{state.scenario}: {state.solved} of {state.units} units solved in {state.cpu_hours_spent:.3g} CPU hours"
    )
    click.echo(f"CPU hours left, on cores like these: {left}")
