"""`gaitflow robot`: robots from their URDF."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import click

from gaitflow.cli.errors import bad_input, print_json
from gaitflow.cli.options import json_option
from gaitflow.config.file import ConfigError
from gaitflow.pipeline.workspace import Workspace
from gaitflow.urdf.description import label_of


@click.group()
def robot() -> None:
    """Import robots from their URDF.

    \b
    Example: gaitflow robot import anymal.urdf --name anymal_b --feet LF_FOOT,RF_FOOT,LH_FOOT,RH_FOOT
    """


@robot.command("import")
@click.argument("urdf", type=click.Path(path_type=Path))
@click.option("--name", required=True, help="What scenarios call the robot: lower case letters, digits and _.")
@click.option("--feet", required=True, help="Links that touch the ground, in the order of the legs: A,B,C,D.")
@click.option("--legs", help="Names of the legs.  [default: LF,RF,LH,RH]")
@click.option("--pose", help="A group_state of the SRDF, or JOINT=RAD,...  [default: standing or half_sitting]")
@click.option(
    "--srdf", type=click.Path(path_type=Path), help="The robot's SRDF.  [default: beside the URDF or in ../srdf]"
)
@click.option("--inertia", type=click.Choice(["composite", "base"]), default="composite", show_default=True,
              help="Inertia of the whole robot in that pose, or of the base link alone.")  # fmt: skip
@click.option("--box", help="Half lengths X,Y,Z [m] of every foot's box.  [default: what the legs reach]")
@click.option("--max-force", type=float, help="Normal force of a foot [N].  [default: from effort limits]")
@click.option(
    "--max-foot-speed",
    type=float,
    help="Largest speed of a foot along each axis [m/s].  [default: from velocity limits]",
)
@click.option(
    "--max-tilt", type=float, default=0.5, show_default=True, help="Largest tilt of the base along each angle [rad]."
)
@click.option("--output", type=click.Path(dir_okay=False, path_type=Path),
              help="File to write or overwrite.  [default: configs/robots/NAME.yaml, if it is new]")  # fmt: skip
@json_option
@click.pass_obj
def import_(workspace: Workspace, /, urdf: Path, output: Path | None, as_json: bool, **options: Any) -> None:
    """Write the YAML file of a legged robot from its URDF.

    Mass, inertia, default feet and limits come from the URDF, in a pose; meshes are not needed. The kinematic box is
    checked against the reach of the legs. The body is made exactly left-right symmetric. Every change is printed.

    \b
    Example: gaitflow robot import anymal.urdf --name anymal_b --feet LF_FOOT,RF_FOOT,LH_FOOT,RH_FOOT
             gaitflow robot import my.urdf --name mine --feet A,B,C,D --pose A_hip=0,A_thigh=0.8,A_calf=-1.6,...
    """
    from gaitflow.urdf.importing import Request, import_robot
    from gaitflow.urdf.write import write_robot

    with bad_input():
        words = {key: None if options[key] is None else _words(options[key]) for key in ("feet", "legs")}
        box = None if options["box"] is None else _half_lengths(options["box"])
        request = Request(urdf, **{**options, **words, "box": box})
        imported = import_robot(request)
        path = output or workspace.root / "configs" / "robots" / f"{imported.robot.name}.yaml"
        comments = [f"Made by: gaitflow robot import {label_of(urdf)} {_given(options)}"]
        try:
            write_robot(path, imported.robot, comments, replace=output is not None)
        except FileExistsError:
            raise ConfigError(f"{path}: is there already; to write over it give --output {path}") from None
    if as_json:
        return print_json({"path": str(path), "robot": imported.robot.as_data(), "found": list(imported.found)})
    for sentence in imported.found:
        click.echo(f"- {sentence}")
    click.echo(path)


def _given(options: dict[str, Any]) -> str:
    """The options as they would be typed again, on any machine."""
    default = {"inertia": "composite", "max_tilt": 0.5}
    parts = []
    for key, value in options.items():
        if value is None or value == default.get(key):
            continue
        parts += [f"--{key.replace('_', '-')}", label_of(value) if isinstance(value, Path) else str(value)]
    return shlex.join(parts)


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(","))


def _half_lengths(text: str) -> tuple[float, ...]:
    try:
        lengths = tuple(float(word) for word in text.split(","))
    except ValueError:
        lengths = ()
    if len(lengths) != 3 or not all(0 < length < float("inf") for length in lengths):
        raise ConfigError(f"--box {text!r}: give three half lengths in m, as in 0.16,0.1,0.04")
    return lengths
