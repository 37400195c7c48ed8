"""Arguments and options that several commands share; among them one option for every axis of a task."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import click

from gaitflow import shipped
from gaitflow.config.file import meant
from gaitflow.core.task import AXES, Axis
from gaitflow.pipeline.snakemake import PROFILE

Command = TypeVar("Command", bound=Callable[..., Any])

SHORT = {"cycle_duration": "--cycle"}  # beside the axis' own name


class PublishedFolder(click.ParamType[Path]):
    """A folder of a map or dataset: a path, or an address, whose newest version is fetched and checked."""

    name = "folder"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The folder on this machine; what cannot be fetched is one line and exit code 2."""
        if isinstance(value, Path):
            return value
        from gaitflow.core.errors import ArtifactError
        from gaitflow.runtime.remote import local_folder

        try:
            return local_folder(value)
        except ArtifactError as error:
            click.echo(f"gaitflow: {error}", err=True)
            sys.exit(2)


PUBLISHED = PublishedFolder()
scenario_argument = click.argument("scenario")
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON document and nothing else.")


def found_profile(context: click.Context, parameter: click.Parameter, name: str | None) -> Path | None:
    """The file of a cluster's profile: a path, or the name of one that ships."""
    if name is None or name.endswith((".yaml", ".yml")):
        return None if name is None else Path(name)
    known = {file.stem: file for file in shipped.PROFILES.glob("*.yaml")}
    if name not in known:
        raise click.BadParameter(
            f"{name!r}: no profile that ships{meant(name, known)} there are {', '.join(sorted(known))}; a path ending "
            "in .yaml works too"
        )
    return known[name]


map_argument = click.argument("artifact", metavar="MAP", type=PUBLISHED)
profile_option = click.option(
    "--profile",
    "profile_file",
    envvar=PROFILE,
    callback=found_profile,
    help="Solve by jobs of this cluster instead: a profile's file, or the name of one that ships.",
)
workers_option = click.option(
    "--workers", default=2, show_default=True, type=click.IntRange(1, 1024), help="Processes that solve."
)


def task_options(command: Command) -> Command:
    """An option for every axis of a task; the command gets those that were given as its argument `axes`, a dict."""

    @wraps(command)
    def collected(*arguments: Any, **options: Any) -> Any:
        given = {axis: options.pop(axis) for axis in AXES}
        axes = {axis: _only(axis, values) for axis, values in given.items() if values}
        return command(*arguments, axes=axes, **options)

    decorated: Any = collected
    for axis in reversed(AXES.values()):
        decorated = click.option(
            *_spelled(axis.name),
            axis.name,
            type=float,
            multiple=True,
            metavar=axis.unit if axis.unit != "1" else "NUMBER",
            help=_told(axis),
        )(decorated)
    result: Command = decorated
    return result


def _only(axis: str, values: tuple[float, ...]) -> float:
    """The one value that was given for an axis; two are refused with one line and exit code 2."""
    if len(values) > 1:
        said = " and ".join(f"{value:g}" for value in values)
        click.echo(f"gaitflow: {_spelled(axis)[0]} is given {len(values)} times: {said}; a task has one", err=True)
        sys.exit(2)
    return values[0]


def _spelled(axis: str) -> tuple[str, ...]:
    own = f"--{axis.replace('_', '-')}"
    return (SHORT[axis], own) if axis in SHORT else (own,)


def _told(axis: Axis) -> str:
    return f"{axis.meaning[0].upper()}{axis.meaning[1:]}."
