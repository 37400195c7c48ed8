"""A stored motion as one HTML file to watch, turn and step through: nothing is loaded from elsewhere.

The file's script and style are named by their digests in its content security policy, so that no text that comes from
a dataset can run, whatever it says.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.check import FEASIBLE, violations
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Array
from gaitflow.report import axis_text
from gaitflow.report.inline import packaged, policy, template
from gaitflow.report.palette import lighter
from gaitflow.report.scene import Scene, scene_of
from gaitflow.report.snapshot import BODY_COLOUR, FORCE_COLOUR, GROUND_COLOUR, SWING_COLOUR
from gaitflow.report.tables import number
from gaitflow.search.solution import Solution

DIGITS = 5  # of stored lengths, angles and forces over weight
PLAYER = ("canvas.js", "animation_view.js", "motion_player.js")


def animation_page(solution: Solution, scenario: Scenario, gait: str, colour: str) -> str:
    """The motion as HTML: the robot in space, its contact bars, cost and constraint violations, all judged anew.

    `gait` is the gait's name, `colour` its hex colour. Raises ValueError when the solution has no trajectory.
    """
    scene = scene_of(solution, scenario)
    assert solution.trajectory is not None
    found = violations(scenario.as_data(), solution.trajectory, solution.task, solution.pattern)
    script = "".join(map(packaged, (*PLAYER, "animation.js")))
    style = packaged("animation.css") + packaged("player.css")
    return template("animation.html.jinja").render(
        title=f"{scenario.robot.name}: {gait}",
        robot=scenario.robot.name,
        gait=gait,
        scenario=scenario.name,
        facts=_facts(solution, scenario.tasks.space, max(found.values())),
        violations=[(kind, f"{value:.1e}", value <= FEASIBLE) for kind, value in found.items()],
        planar=scene.planar,
        data=animation_data(scene, solution, scenario, colour),
        script=script,
        style=style,
        policy=policy(script, style),
    )


def animation_data(scene: Scene, solution: Solution, scenario: Scenario, colour: str) -> dict[str, Any]:
    """What the player's script draws, as plain data: metres, radians and seconds; forces over the robot's weight."""
    return robot_data(scene, scenario) | motion_data(scene, colour, DIGITS)


def robot_data(scene: Scene, scenario: Scenario) -> dict[str, Any]:
    """The part of `animation_data` that all motions of a scenario share."""
    return {
        "planar": scene.planar,
        "height": scene.height,
        "legs": list(scenario.robot.leg_names),
        "hips": _rounded(scene.hips, DIGITS),
        "defaultFeet": _rounded(scene.default_feet, DIGITS),
        "box": _rounded(scene.box, DIGITS),
        "body": _rounded(scene.body, DIGITS),
    }


def motion_data(scene: Scene, colour: str, digits: int) -> dict[str, Any]:
    """The part of `animation_data` that is one motion, rounded to so many digits behind the point."""
    series = {
        "times": scene.times,
        "path": scene.path,
        "headings": scene.headings,
        "position": scene.position,
        "velocity": scene.velocity,
        "angles": scene.angles,
        "angleRates": scene.angle_rates,
        "feet": scene.feet,
        "forces": scene.forces / scene.weight,
        "endForces": scene.end_forces / scene.weight,
        "durations": scene.durations,
    }
    colours = {
        "stance": colour,
        "pale": lighter(colour, 0.8),
        "swing": SWING_COLOUR,
        "force": FORCE_COLOUR,
        "body": BODY_COLOUR,
        "ground": GROUND_COLOUR,
    }
    rounded = {name: _rounded(values, digits) for name, values in series.items()}
    return rounded | {"slope": scene.slope, "curved": scene.curved, "rows": list(scene.rows), "colours": colours}


def _facts(solution: Solution, space: TaskSpace, worst: float) -> list[tuple[str, str]]:
    verdict = "feasible" if worst <= FEASIBLE else "NOT feasible"
    return [
        *((axis_text.words(axis), axis_text.quantity(axis, solution.task[axis])) for axis in space.columns),
        ("pattern", solution.pattern),
        ("cost", number(solution.cost)),
        ("worst violation", f"{worst:.1e}, {verdict}"),
    ]


def _rounded(values: Array, digits: int) -> Any:
    return (np.round(values, digits) + 0.0).tolist()  # no "-0.0"
