"""`gaitflow drive`: a robot in MuJoCo follows a speed that changes, replanned 50 times a second from a map."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact
from gaitflow.cli.options import json_option, map_argument
from gaitflow.cli.walk import VIDEOS
from gaitflow.config.file import ConfigError

if TYPE_CHECKING:
    from gaitflow.clients.drive import Drive
    from gaitflow.clients.robot_model import RobotModel


@click.command()
@map_argument
@click.option("--top", default=1.2, show_default=True, type=click.FloatRange(0, min_open=True), help="Top speed [m/s].")
@click.option(
    "--seconds", default=60.0, show_default=True, type=click.FloatRange(5, 3600), help="Duration of the drive [s]."
)
@click.option(
    "--noise", default=0.02, show_default=True, type=click.FloatRange(0, 1), help="Noise of the command [m/s]."
)
@click.option("--seed", default=0, show_default=True, help="Seed of the noise.")
@click.option(
    "--urdf",
    type=click.Path(dir_okay=False, path_type=Path),
    help="The robot's URDF; needed when the robot was not imported from example-robot-data.",
)
@click.option(
    "--video",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write an animated .html page, or a .png with speeds and gaits over time.",
)
@json_option
def drive(
    artifact: Path, top: float, seconds: float, noise: float, seed: int, urdf: Path | None, video: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Drive a robot in MuJoCo from a stand to a top speed and back.

    MAP is the folder of a version, or its parent. Only the speed is commanded, with noise. 50 times a second the map
    chooses gait and cycle duration, and planned transitions lead from one to the next. Exit code 1 means that the
    robot fell.

    \b
    Example: gaitflow drive models/anymal-energy --video drive.png
             gaitflow drive models/anymal-energy --top 0.8 --seconds 30 --json
    """
    from gaitflow.runtime import GaitMap, NoTransition, OutOfDomain

    with bad_input(), refused_artifact():
        if video is not None and video.suffix not in VIDEOS:
            raise ConfigError(f"--video {video}: must end in {' or '.join(VIDEOS)}")
        try:
            from gaitflow.clients.description import describe
            from gaitflow.clients.drive import Course
            from gaitflow.clients.drive import drive as drive_in_mujoco
            from gaitflow.clients.pilot import Pilot
            from gaitflow.clients.robot_model import RobotModel
        except ImportError as error:
            raise ConfigError(f'driving needs more than planning ({error}): pip install "gaitflow[clients]"') from None
        gait_map = GaitMap.load(artifact)
        scenario = gait_map.manifest.scenario
        try:
            pilot = Pilot(gait_map)
            robot = RobotModel.of(describe(scenario, urdf), scenario, pilot.first.task)
            with _progress(seconds) as each:
                driven = drive_in_mujoco(pilot, robot, Course(top, seconds, noise, seed), each)
        except (OutOfDomain, NoTransition) as error:
            fail(str(error))
        if video is not None:
            _write(video, driven, robot, str(scenario["robot"]["name"]))
    if as_json:
        print_json(driven.as_data())
    else:
        for name, value in _table(driven):
            click.echo(f"{name + ':':<20} {value}")
        if video is not None:
            click.echo(video)
    if driven.fell is not None:
        sys.exit(1)


@contextmanager
def _progress(seconds: float) -> Iterator[Callable[[float], None]]:
    """What is told the simulated time [s]: a bar on a terminal's standard error, and nothing elsewhere."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("driving", total=seconds)
        yield lambda time: bar.update(task, completed=time)


def _table(driven: Drive) -> list[tuple[str, str]]:
    """Names and values of what there is to say."""
    data: dict[str, Any] = driven.as_data()
    ticks, control, planning = data["tick_ms"], data["control_ms"], data["planning_s"]
    return [
        ("drove", "yes" if driven.fell is None else f"fell at {driven.fell:.2f} s"),
        ("changes", f"{data['gait_changes']} of gait, {data['speed_changes']} of speed alone; "
                    f"{data['no_transition']} not found, {data['late']} planned late"),
        ("gaits", ", ".join(dict.fromkeys(gait or "stands" for _, gait in driven.gaits))),
        ("speed", f"{data['speed_error']:.3f} m/s off (rms)"),
        ("asking the map", f"{ticks['median']:.2f} ms, p99 {ticks['p99']:.2f} ms a tick of 20 ms"),
        ("control", f"{control['median']:.2f} ms, p99 {control['p99']:.2f} ms a step of 2 ms, physics included"),
        ("planning a change", f"{planning['median']:.2f} s, at most {planning['max']:.2f} s, before it begins"),
    ]  # fmt: skip


def _write(path: Path, driven: Drive, robot: RobotModel, name: str) -> None:
    from gaitflow.clients.pictures import scene_of_walk
    from gaitflow.files import new_file
    from gaitflow.report.drive_chart import drive_chart
    from gaitflow.report.palette import NAMED_COLOURS
    from gaitflow.report.walk_page import walk_page

    title = f"{name}: a drive of {driven.times[-1]:.0f} s"
    if path.suffix == ".png":
        content = drive_chart(driven.times, driven.commanded, driven.speeds, driven.gaits, f"{title}, simulated")
    else:
        scene = scene_of_walk(robot, driven.first, driven)
        content = walk_page(scene, title, _table(driven), NAMED_COLOURS["walking"]).encode()
    with new_file(path, replace=True) as file:
        file.write(content)
