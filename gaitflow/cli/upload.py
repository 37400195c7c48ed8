"""`gaitflow upload`: a published version at an address."""

from __future__ import annotations

from pathlib import Path

import click

from gaitflow.cli.errors import bad_input, fail, refused_artifact


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.argument("address")
def upload(folder: Path, address: str) -> None:
    """Publish a map or dataset at an address as well.

    FOLDER is the folder of a version, or its parent; then the newest version is taken. ADDRESS is any that fsspec
    knows, such as s3://bucket/models. The version goes to ADDRESS/<scenario>/<version>. Every command takes that
    address instead of a folder, and checks each file when it loads it.

    \b
    Example: gaitflow upload models/anymal-energy s3://my-bucket/models
             gaitflow plan s3://my-bucket/models/anymal-energy --speed 0.8
    """
    try:
        from gaitflow.publishing import PublishError
        from gaitflow.publishing.find import version_folder
        from gaitflow.publishing.upload import upload as upload_version
    except ImportError as missing:
        fail(f'an upload needs {missing.name}: pip install "gaitflow[workflow,remote]"')
    with bad_input(), refused_artifact():
        try:
            click.echo(upload_version(version_folder(folder), address))
        except PublishError as error:
            fail(str(error))
