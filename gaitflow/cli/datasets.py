"""`gaitflow datasets`: published datasets for others."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option, scenario_argument
from gaitflow.pipeline.workspace import Workspace


@click.group()
def datasets() -> None:
    """Publish searches, and prepare published datasets for others.

    \b
    Example: gaitflow datasets describe datasets/anymal-energy --output anymal-energy-1.0.0
    """


@datasets.command()
@click.argument("dataset", type=PUBLISHED)
@click.option("--output", required=True, type=click.Path(file_okay=False, path_type=Path), help="The folder to write.")
@json_option
def describe(dataset: Path, output: Path, as_json: bool) -> None:
    """Copy a dataset with all that others need to use it.

    DATASET is the folder of a version, or its parent. With its tables the folder gets a card (which the Hugging Face
    hub reads), Croissant metadata, a Workflow Run Crate, and the workflow that makes the dataset again. The published
    version stays as it is.

    \b
    Example: gaitflow datasets describe datasets/anymal-energy --output anymal-energy-1.0.0
    """
    from gaitflow.publishing.describe import describe_dataset
    from gaitflow.publishing.find import is_dataset, version_folder

    with bad_input(), refused_artifact():
        folder = version_folder(dataset)
        if not is_dataset(folder):
            raise ValueError(f"{folder}: is a map, not a dataset; give one such as datasets/<scenario>")
        written = describe_dataset(folder, output)
    if as_json:
        return print_json([str(path) for path in written])
    click.echo("\n".join(map(str, written)))


@datasets.command()
@scenario_argument
@click.pass_obj
def publish(workspace: Workspace, scenario: str) -> None:
    """Publish the searches of SCENARIO as a dataset, without a map.

    Of an adaptive sampling that was stopped these are the searches so far: a later one can begin from them, on another
    machine, too.

    \b
    Example: gaitflow datasets publish anymal-omni
             gaitflow solve anymal-omni --begin datasets/anymal-omni
    """
    from gaitflow.dataset.collect import NotComplete
    from gaitflow.pipeline.searches import publish_searches

    with bad_input():
        resolved = workspace.scenario(scenario)
        try:
            folder = publish_searches(workspace, resolved)
        except NotComplete as error:
            fail(str(error))
    click.echo(f"dataset:  {folder}")
