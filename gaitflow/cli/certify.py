"""`gaitflow certify`: how good a published map is, with a guarantee."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option, workers_option
from gaitflow.pipeline.workspace import Workspace

SHOWN = 10


@click.command()
@click.argument("map_folder", metavar="MAP", type=PUBLISHED)
@click.option("--tasks", type=click.IntRange(min=1), help="Tasks to search; by default as many as bound 2 %.")
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Of the random tasks.")
@workers_option
@json_option
@click.pass_obj
def certify(workspace: Workspace, map_folder: Path, tasks: int | None, seed: int, workers: int, as_json: bool) -> None:
    """Search random tasks of MAP's domain and say with 95 % confidence how many of its plans may be wrong.

    Each task is searched as the map's scenario says, from nothing that is known, which takes minutes to hours. Stop it
    with Ctrl-C; the same command goes on where it stopped.

    \b
    Example: gaitflow certify models/half-cheetah-exact-vibration --tasks 200 --seed 7
    """
    from gaitflow.certificate.draw import EmptyDomain
    from gaitflow.execute.drivers import DriverAlive
    from gaitflow.execute.run import RunFailed
    from gaitflow.pipeline.certify import certify_map

    with bad_input(), refused_artifact():
        try:
            certificate, verdicts, gait_map = certify_map(workspace, map_folder, workers, tasks, seed)
        except (RunFailed, DriverAlive, EmptyDomain) as error:
            fail(str(error))
    names, axes = {gait.key: gait.name for gait in gait_map.gaits}, gait_map.axes
    wrong = sorted((one for one in verdicts if one.dearer), key=lambda one: -one.excess)
    if as_json:
        listed = [
            {
                "task": {axis: one.task[axis] for axis in axes},
                "gait": names[one.pick],
                "best": one.best,
                "excess": None if one.infeasible else one.excess,
            }
            for one in wrong
        ]
        return print_json(certificate.as_data() | {"map": gait_map.manifest.name, "wrong": listed})
    click.echo(f"{gait_map.manifest.name} {gait_map.manifest.version}: {certificate}")
    for one in wrong[:SHOWN]:
        how = "not planned" if one.infeasible else f"{one.excess:.1%} dearer"
        click.echo(
            f"  {one.task.text(axes)}: {names[one.pick]} {how}, the search found {names.get(one.best, one.best)}"
        )
    if len(wrong) > SHOWN:
        click.echo(f"  and {len(wrong) - SHOWN} more; --json lists all")
