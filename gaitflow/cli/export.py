"""`gaitflow export`: a published map for planners that are not Python."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option


@click.command()
@click.argument("model", metavar="MAP", type=PUBLISHED)
@click.option(
    "--c",
    "folder",
    required=True,
    type=click.Path(path_type=Path),
    help="The folder to write: C functions, map.bin, and a C++17 planner.",
)
@click.option("--trust-code", is_flag=True, help="Run the code that maps of formats 1 and 2 hold as their problem.")
@json_option
def export(model: Path, folder: Path, trust_code: bool, as_json: bool) -> None:
    """Write MAP as C, C++ and data for planners without Python.

    MAP is the folder of a version, or its parent. docs/other-languages.md says how to use what is written.

    \b
    Example: gaitflow export models/quickstart --c quickstart-c
    """
    try:
        from gaitflow.export import export_c
    except ImportError as missing:
        fail(f'an export needs {missing.name}: pip install "gaitflow[solve,learn]"')
    with bad_input(), refused_artifact("--trust-code"):
        done = export_c(model, folder, trust_code)
    if as_json:
        return print_json({"model": str(done.model), "folder": str(done.folder), "files": done.sizes})
    click.echo(f"{done.model} -> {done.folder}")
    for name, size in done.sizes.items():
        click.echo(f"{size:10d}  {name}")
