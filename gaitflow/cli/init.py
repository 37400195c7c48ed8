"""`gaitflow init`: a folder to make maps in."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input
from gaitflow.pipeline.new_workspace import new_workspace


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
def init(folder: Path) -> None:
    """Make FOLDER a workspace for maps.

    It gets a scenario and a robot to change, a README and a .gitignore.

    \b
    Example: gaitflow init my-maps
    """
    with bad_input():
        written = new_workspace(folder)
    click.echo("\n".join(map(str, written)))
    click.echo(f"go on with: cd {folder} && gaitflow run quickstart")
