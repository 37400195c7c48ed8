"""A stored motion as one HTML file to watch, turn and step through: nothing is loaded from elsewhere.

The file's script and style are named by their digests in its content security policy, so that no text that comes from
a dataset can run, whatever it says.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from jinja2 import Environment, StrictUndefined

from gaitflow.config.scenario import Scenario
from gaitflow.core.check import FEASIBLE, violations
from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Array
from gaitflow.report import axis_text
from gaitflow.report.inline import packaged, policy
from gaitflow.report.palette import lighter
from gaitflow.report.scene import Scene, scene_of
from gaitflow.report.snapshot import BODY_COLOUR, FORCE_COLOUR, GROUND_COLOUR, SWING_COLOUR
from gaitflow.report.tables import number
from gaitflow.search.solution import Solution

DIGITS = 5  # of stored lengths, angles and forces over weight


def animation_page(solution: Solution, scenario: Scenario, gait: str, colour: str) -> str:
    """The motion as HTML: the robot in space, its contact bars, cost and constraint violations, all judged anew.

    `gait` is the gait's name, `colour` its hex colour. Raises ValueError when the solution has no trajectory.
    """
    scene = scene_of(solution, scenario)
    assert solution.trajectory is not None
    found = violations(scenario.as_data(), solution.trajectory, solution.task, solution.pattern)
    script, style = packaged("animation_view.js") + packaged("animation.js"), packaged("animation.css")
    template = Environment(autoescape=True, undefined=StrictUndefined).from_string(packaged("animation.html.jinja"))
    return template.render(
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


def animation_data(scene: Scene, solution: Solution, scenario: Scenario, colour: str) -> Mapping[str, Any]:
    """What the script draws, as plain data: metres, radians and seconds; forces over the robot's weight."""
    return {
        "planar": scene.planar,
        "slope": scene.slope,
        "height": scene.height,
        "curved": scene.curved,
        "times": _rounded(scene.times),
        "path": _rounded(scene.path),
        "headings": _rounded(scene.headings),
        "position": _rounded(scene.position),
        "velocity": _rounded(scene.velocity),
        "angles": _rounded(scene.angles),
        "angleRates": _rounded(scene.angle_rates),
        "feet": _rounded(scene.feet),
        "forces": _rounded(scene.forces / scene.weight),
        "endForces": _rounded(scene.end_forces / scene.weight),
        "durations": _rounded(scene.durations),
        "rows": list(scene.rows),
        "legs": list(scenario.robot.leg_names),
        "hips": _rounded(scene.hips),
        "defaultFeet": _rounded(scene.default_feet),
        "box": _rounded(scene.box),
        "body": _rounded(scene.body),
        "colours": {
            "stance": colour,
            "pale": lighter(colour, 0.8),
            "swing": SWING_COLOUR,
            "force": FORCE_COLOUR,
            "body": BODY_COLOUR,
            "ground": GROUND_COLOUR,
        },
    }


def _facts(solution: Solution, space: TaskSpace, worst: float) -> list[tuple[str, str]]:
    verdict = "feasible" if worst <= FEASIBLE else "NOT feasible"
    return [
        *((axis_text.words(axis), axis_text.quantity(axis, solution.task[axis])) for axis in space.columns),
        ("pattern", solution.pattern),
        ("cost", number(solution.cost)),
        ("worst violation", f"{worst:.1e}, {verdict}"),
    ]


def _rounded(values: Array) -> Any:
    return np.round(values, DIGITS).tolist()
