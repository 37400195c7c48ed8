"""`gaitflow walk`: a robot of a published map walks in MuJoCo."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gaitflow.cli.errors import bad_input, fail, print_json, refused_artifact
from gaitflow.cli.options import json_option, map_argument, task_options
from gaitflow.cli.plan import plan_data
from gaitflow.config.file import ConfigError

if TYPE_CHECKING:
    from gaitflow.clients.record import WalkRecord
    from gaitflow.clients.robot_model import RobotModel
    from gaitflow.clients.walking import Walk
    from gaitflow.motion import Motion
    from gaitflow.runtime import Plan

VIDEOS = (".html", ".png")


@click.command()
@map_argument
@task_options
@click.option("--gait", help="Walk in this gait of the map instead of the cheapest.")
@click.option(
    "--urdf",
    type=click.Path(dir_okay=False, path_type=Path),
    help="The robot's URDF; needed when the robot was not imported from example-robot-data.",
)
@click.option("--cycles", default=10, show_default=True, type=click.IntRange(1, 1000), help="Measured cycles.")
@click.option(
    "--video",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write an animated .html page, or a .png with poses in a row.",
)
@json_option
def walk(
    artifact: Path, axes: dict[str, Any], gait: str | None, urdf: Path | None, cycles: int, video: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Plan a motion from MAP and simulate the whole robot in MuJoCo.

    MAP is the folder of a version, or its parent. The controller follows the plan's body and swings, with contact
    forces from a quadratic program. The first two cycles are not measured. Exit code 1 means that the robot fell, or
    did not move as commanded.

    \b
    Example: gaitflow walk models/anymal-exact-vibration --speed 0.6 --cycle 0.6 --video walk.html
             gaitflow walk models/go1-exact-vibration --speed 0.6 --json
    """
    from gaitflow.runtime import GaitMap, OutOfDomain

    with bad_input(), refused_artifact():
        if video is not None and video.suffix not in VIDEOS:
            raise ConfigError(f"--video {video}: must end in {' or '.join(VIDEOS)}")
        try:
            from gaitflow.clients.description import describe
            from gaitflow.clients.robot_model import RobotModel
            from gaitflow.clients.walking import walk as walk_in_mujoco
        except ImportError as error:
            raise ConfigError(f'walking needs more than planning ({error}): pip install "gaitflow[clients]"') from None
        try:
            plan = GaitMap.load(artifact).plan(gait=gait, **axes)
        except OutOfDomain as error:
            fail(str(error))
        if not plan.feasible:
            fail(f"no feasible motion at this task: worst violation {plan.violation:.1e}")
        motion = plan.motion(point="base")
        robot = RobotModel.of(describe(plan.scenario, urdf), plan.scenario, motion.task)
        walked = walk_in_mujoco(robot, motion, cycles)
        if video is not None:
            _write(video, plan, motion, robot, walked)
    if as_json:
        print_json({"plan": plan_data(plan), "walk": walked.record.as_data()})
    else:
        for name, value in _table(plan, walked.record):
            click.echo(f"{name + ':':<20} {value}")
        if video is not None:
            click.echo(video)
    if not walked.record.walked:
        sys.exit(1)


def _table(plan: Plan, record: WalkRecord) -> list[tuple[str, str]]:
    """Names and values of what there is to say."""
    verdict = (
        "yes" if record.walked else "no, not as commanded" if record.fell is None else f"fell at {record.fell:.2f} s"
    )
    ahead, asked, transport = record.velocity, record.commanded, "none, as the command is to stay"
    if record.cost_of_transport is not None:
        transport = f"{record.cost_of_transport:.3f} (positive work of all joints)"
    return [
        ("gait", plan.gait),
        ("walked", verdict),
        ("speed", f"{ahead[0]:.3f} m/s, to the left {ahead[1]:+.3f}; commanded {asked[0]:.3f} and {asked[1]:+.3f}"),
        ("measured", f"{record.duration:.2f} s, {record.distance:.2f} m, {record.stances} stances"),
        ("turned", f"{record.turning:+.3f} rad/s to the left; commanded {record.commanded_turning:+.3f}"),
        ("cost of transport", transport),
        ("heat", f"{record.heat / record.duration:.0f} N^2 m^2 (mean of the squared torques, all joints)"),
        ("force", f"{record.mean_square_force:.0f} N^2 (mean square, all feet)"),
        ("impact", f"{record.impact:.0f} N"),
        ("tilt", f"{record.tilt:.4f} rad"),
        ("slip", f"{record.slip * 1e3:.1f} mm a stance"),
        ("saturated", f"{record.saturated:.1%} of the time"),
        (
            "off the plan",
            f"{record.position_error * 1e3:.0f} mm, {record.velocity_error:.3f} m/s, {record.heading_error:.3f} rad",
        ),
    ]


def _write(path: Path, plan: Plan, motion: Motion, robot: RobotModel, walked: Walk) -> None:
    from gaitflow.clients.pictures import scene_of_walk
    from gaitflow.files import new_file
    from gaitflow.report.palette import gait_colours
    from gaitflow.report.walk_page import walk_page
    from gaitflow.report.walk_strip import walk_strip

    scene, colour = scene_of_walk(robot, motion, walked), gait_colours([plan.gait])[plan.gait]
    title = f"{plan.scenario['robot']['name']}: {plan.gait}"
    if path.suffix == ".png":
        content = walk_strip(scene, f"{title}, {walked.record.velocity[0]:.2f} m/s, simulated", colour)
    else:
        content = walk_page(scene, title, _table(plan, walked.record), colour).encode()
    with new_file(path, replace=True) as file:
        file.write(content)
