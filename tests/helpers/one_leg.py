"""As much of a scenario as the tables look at."""

from __future__ import annotations

from typing import Any


def one_leg(linear: bool, knots: int = 2) -> dict[str, Any]:
    """JSON data of a scenario of one leg in the plane, 2 phases, with a range of slopes."""
    return {
        "name": "small",
        "robot": {"dimension": 2, "legs": [{"name": "F"}], "mass": 1.0},
        "transcription": {"phases": 2, "knots_per_phase": knots, "forces": "linear" if linear else "held"},
        "tasks": {
            "axes": {
                "speed": {"start": 0.0, "stop": 1.0, "count": 2},
                "cycle_duration": 0.5,
                "slope": {"start": -5.0, "stop": 5.0, "count": 2},
                "friction": 0.6,
            }
        },
    }
