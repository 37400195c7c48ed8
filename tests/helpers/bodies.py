"""Robots as JSON data, for what needs no configuration: a planar pair of legs, and a quadruped with any inertia."""

from __future__ import annotations

from typing import Any

PLANAR: dict[str, Any] = {
    "dimension": 2,
    "mass": 14.0,
    "inertia": [[1.2]],
    "legs": [{"default_foot": [0.4, -0.5]}, {"default_foot": [-0.3, -0.5]}],
    "box": [0.2, 0.1],
}
SPATIAL: dict[str, Any] = {
    "dimension": 3,
    "mass": 30.0,
    "inertia": [[1.0, 0.1, -0.2], [0.1, 2.0, 0.05], [-0.2, 0.05, 2.1]],
    "legs": [{"default_foot": [x, y, -0.45]} for x in (0.4, -0.35) for y in (0.2, -0.2)],
    "box": [0.2, 0.1, 0.05],
}
