"""`gaitflow show`: draw a stored motion as an animation (HTML, GIF) or a strip of snapshots."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, print_json, refused_artifact
from gaitflow.cli.options import PUBLISHED, json_option, task_options

if TYPE_CHECKING:
    from gaitflow.report.stored import Ranked


@click.command()
@click.argument("folder", type=PUBLISHED)
@task_options
@click.option("--gait", help="Draw the gait of this name; by default the one planned, or stored at least cost.")
@click.option("--rank", type=click.IntRange(1), help="Draw the gait of this rank: 1 costs least.")
@click.option(
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write an animation: an .html page or a .gif.",
)
@click.option("--strip", type=click.Path(dir_okay=False, path_type=Path), help="Write snapshots: one PNG file.")
@json_option
def show(
    folder: Path,
    axes: dict[str, float],
    gait: str | None,
    rank: int | None,
    output: Path | None,
    strip: Path | None,
    as_json: bool,
) -> None:
    """List the gaits of a task by cost, or draw a motion.

    FOLDER is a published map or dataset (the folder of a version, or its parent) or a run. A map plans the task, and
    lists its gaits in the order in which it takes them; of a dataset or a run the nearest stored task is taken. With
    --output or --strip a motion is drawn, without them the gaits are listed.

    \b
    Example: gaitflow show datasets/quickstart/1.0.0 --speed 0.9 --cycle 0.6 --output motion.html --strip motion.png
             gaitflow show models/anymal-energy --speed 0.8 --output trot.html
    """
    if gait is not None and rank is not None:
        raise click.UsageError("give --gait or --rank, not both")
    if output is not None and strip is not None and output.resolve() == strip.resolve():
        raise click.UsageError(f"--output and --strip are both {output}; the second would overwrite the first")
    with bad_input(), refused_artifact():
        from gaitflow.files import atomic_write
        from gaitflow.publishing.find import is_map, version_folder
        from gaitflow.report.animation import animation_page
        from gaitflow.report.film import film
        from gaitflow.report.motion import draw_motion
        from gaitflow.report.palette import gait_colours
        from gaitflow.report.planned import of_map
        from gaitflow.report.report import png_of
        from gaitflow.report.stored import chosen, of_dataset

        version = folder if folder.is_file() else version_folder(folder)
        shown = of_map(version, axes, gait) if is_map(version) else of_dataset(version, axes)
        ranked = shown.ranked
        files = []
        if output is not None or strip is not None or gait is not None or rank is not None:
            one = shown.first() if gait is None and rank is None else chosen(ranked, gait, rank)
            ranked = (one,)
        if output is not None or strip is not None:
            drawn = shown.motion(one), shown.scenario, one.gait, gait_colours([one.gait])[one.gait]
            if output is not None:
                atomic_write(output, film(*drawn) if output.suffix == ".gif" else animation_page(*drawn).encode())
                files.append(output)
            if strip is not None:
                atomic_write(strip, png_of(draw_motion(*drawn)))
                files.append(strip)
    columns = shown.scenario.tasks.space.columns
    if as_json:
        return print_json(_as_data(dict(zip(columns, shown.task.on(columns), strict=True)), ranked, files))
    asked = ", ".join(f"{axes[name]:g}" for name in columns if name in axes)
    click.echo(f"{shown.title}: {shown.task.text(columns)} (asked: {asked})")
    for one in ranked:
        click.echo(f"{one.rank:4d}  cost {one.cost:<12.6g} {'' if one.has_motion else '(no motion stored) '}{one.gait}")
    for path in files:
        click.echo(path)


def _as_data(task: dict[str, float], ranked: tuple[Ranked, ...], files: list[Path]) -> dict[str, Any]:
    keys = ("rank", "gait", "pattern", "cost", "has_motion")
    return task | {
        "gaits": [{key: getattr(one, key) for key in keys} for one in ranked],
        "files": [str(path) for path in files],
    }
