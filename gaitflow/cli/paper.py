"""`gaitflow paper`: the paper's figures from published data."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, print_json, refused_artifact
from gaitflow.cli.options import json_option
from gaitflow.pipeline.workspace import Workspace


@click.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
@json_option
@click.pass_obj
def paper(workspace: Workspace, folder: Path, as_json: bool) -> None:
    """Draw figures 4 to 10 of the paper into FOLDER.

    They are drawn from published datasets and maps; nothing is solved. Each figure is drawn twice: by the paper's
    forward Euler, and by exact motion. docs/reproduce.md says which is which.

    \b
    Example: gaitflow paper figures
    """
    from gaitflow.report.paper_figures import write_paper_figures

    written = []
    with bad_input(), refused_artifact():
        for path in write_paper_figures(folder, workspace.datasets, workspace.models):
            written.append(str(path))
            if not as_json:
                click.echo(path)
    if as_json:
        print_json(written)
