"""Scenarios and names of gaits as published maps and tables of earlier formats have them, in today's form."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from gaitflow.core.gaits import Pattern
from gaitflow.core.names import is_grounded_run

# What every published scenario says, though a file of YAML may leave it to its default.
_WRITTEN = {
    "transcription": ("phases", "knots_per_phase", "integrator", "min_phase_fraction"),
    "strategy": ("name",),
    "learning": ("tie_tolerance",),
}
_WALK = re.compile(r"([a-z]+-beat) walk ([01/]+)")


def modern_scenario(data: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario's JSON data with its tasks as axes; what has that form already comes back as it is.

    The older form has `terrain: {slope_deg, friction}`, and `tasks` with the ranges of speed [m/s] and cycle_duration
    [s] beside held_out and held_out_seed. Its forces were held over a step and its knots evenly spaced. `data` is not
    changed. Raises ValueError for data that has neither form, or leaves out what a published scenario says.
    """
    modern = _with_axes(data)
    for part, names in _WRITTEN.items():
        held = modern.get(part, {})
        if isinstance(held, Mapping) and (missing := [name for name in names if name not in held]):
            raise ValueError(f"a scenario without {part}.{missing[0]}")
    return modern


def _with_axes(data: Mapping[str, Any]) -> dict[str, Any]:
    tasks = data.get("tasks")
    if isinstance(tasks, Mapping) and isinstance(tasks.get("axes"), Mapping):
        return dict(data)
    try:
        axes = {
            "speed": dict(data["tasks"]["speed"]),
            "cycle_duration": dict(data["tasks"]["cycle_duration"]),
            "slope": float(data["terrain"]["slope_deg"]),
            "friction": float(data["terrain"]["friction"]),
        }
        transcription = {"forces": "held", "grading": 0.0} | dict(data["transcription"])
        split = {key: data["tasks"][key] for key in ("held_out", "held_out_seed") if key in data["tasks"]}
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"a scenario without tasks.axes, and not of the older form either: {error!r}") from None
    kept = {key: value for key, value in data.items() if key != "terrain"}
    return kept | {"tasks": {"axes": axes, **split}, "transcription": transcription}


def modern_name(name: str) -> str:
    """A gait's name of today: grounded runs were called walks before names told a duty factor."""
    walk = _WALK.fullmatch(name)
    try:
        return f"{walk[1]} grounded run {walk[2]}" if walk and is_grounded_run(Pattern.from_text(walk[2])) else name
    except ValueError:  # no pattern, so no name of ours
        return name
