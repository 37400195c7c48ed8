"""`gaitflow compact`: move the many small files of a run into a few large ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gaitflow.cli.errors import bad_input, fail, print_json
from gaitflow.cli.options import json_option

if TYPE_CHECKING:
    from gaitflow.pipeline.workspace import Workspace


@click.command()
@click.argument("scenario")
@json_option
@click.pass_obj
def compact(workspace: Workspace, scenario: str, as_json: bool) -> None:
    """Move the small files of a run into a few large ones.

    Each solved unit of SCENARIO is a small file; use this where the number of files is limited. Solved units stay
    solved. The run may go on afterwards, or meanwhile.

    \b
    Example: gaitflow compact quickstart
    """
    from gaitflow.store.compact import NotPacked
    from gaitflow.store.compact import compact as compact_store
    from gaitflow.store.parts import UnitStore

    with bad_input():
        resolved = workspace.scenario(scenario)
        store = UnitStore(workspace.run(resolved).folder)
        try:
            done = compact_store(store)
        except NotPacked as error:
            fail(str(error))
    if as_json:
        print_json({"parts": done.parts, "packs": done.packs, "bytes": done.bytes, "damaged": done.damaged})
    else:
        click.echo(f"{resolved.name}: {done.parts} part(s) moved into {done.packs} pack(s), {done.bytes / 1e6:.1f} MB")
        for reason in done.damaged.values():
            click.echo(f"damaged, in {store.folder / 'quarantine'}: {reason}", err=True)
    if done.damaged:
        fail(f"{len(done.damaged)} damaged part(s) have to be solved again: gaitflow solve {resolved.name}")
