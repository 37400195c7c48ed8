"""A walk as one HTML file to watch and turn, numbers beside it: nothing is loaded from elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gaitflow.core.trajectory import Array
from gaitflow.report.inline import packaged, policy, template
from gaitflow.report.palette import lighter
from gaitflow.report.snapshot import BODY_COLOUR, FORCE_COLOUR, SWING_COLOUR
from gaitflow.report.walk_scene import EDGES, WalkScene

DIGITS = 4  # of stored lengths and forces over weight


def walk_page(scene: WalkScene, title: str, facts: Sequence[tuple[str, str]], colour: str) -> str:
    """The walk as HTML; facts are (name, value) pairs shown above it, colour the gait's hex colour."""
    script = packaged("canvas.js") + packaged("walk.js")
    style = packaged("animation.css") + packaged("player.css")
    return template("walk.html.jinja").render(
        title=title, facts=facts, data=_data(scene, colour), script=script, style=style, policy=policy(script, style)
    )


def _data(scene: WalkScene, colour: str) -> dict[str, Any]:
    """What the script draws, as plain data."""
    return {
        "times": _rounded(scene.times),
        "middle": _rounded(scene.middle),
        "body": _rounded(scene.body),
        "legs": _rounded(scene.legs),
        "forces": _rounded(scene.forces),
        "ground": round(scene.ground, DIGITS),
        "height": round(scene.height, DIGITS),
        "names": list(scene.leg_names),
        "edges": EDGES,
        "touching": [[int(stands) for stands in row] for row in scene.touching[:: _every(scene)]],
        "touchingStep": scene.step * _every(scene),
        "period": round(float(scene.durations.sum()), DIGITS),
        "colours": {
            "stance": colour,
            "pale": lighter(colour, 0.8),
            "swing": SWING_COLOUR,
            "force": FORCE_COLOUR,
            "body": BODY_COLOUR,
        },
    }


def _every(scene: WalkScene) -> int:
    """Contacts are drawn 200 times a second."""
    return max(1, round(0.005 / scene.step))


def _rounded(values: Array) -> Any:
    return np.round(values, DIGITS).tolist()
