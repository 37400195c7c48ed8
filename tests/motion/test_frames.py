"""The frames of a map: read from its scenario, refused where they are not a robot's."""

from __future__ import annotations

from typing import Any

import pytest

from gaitflow.motion import FootFrame, Frames
from gaitflow.motion.frames import are_frames

LEGS = [{"name": "LF"}, {"name": "RF"}]


def frames() -> dict[str, Any]:
    feet = [{"leg": leg["name"], "link": f"{leg['name']}_FOOT", "contact_point": [0.0, 0, -0.01]} for leg in LEGS]
    return {"base_link": "base", "com_in_base": [0.01, 0.0, -0.02], "feet": feet}


def test_frames_of_a_scenario() -> None:
    assert Frames.of({"robot": {"legs": LEGS}}) is None
    found = Frames.of({"robot": {"legs": LEGS, "frames": frames()}})
    assert found is not None
    assert (found.base_link, found.com_in_base) == ("base", (0.01, 0.0, -0.02))
    assert found.feet[1] == FootFrame("RF", "RF_FOOT", (0.0, 0.0, -0.01))
    assert are_frames(frames(), LEGS)


@pytest.mark.parametrize("change", [
    {"base_link": ""}, {"base_link": "x" * 201}, {"base_link": 1}, {"com_in_base": [0.0, 0.0]},
    {"com_in_base": [0.0, 0.0, float("nan")]}, {"com_in_base": [0, 0, 10**400]}, {"com_in_base": "abc"},
    {"com_in_base": [0.0, 0.0, True]}, {"feet": []}, {"feet": frames()["feet"][::-1]}, {"feet": [None, None]},
    {"feet": [frames()["feet"][0] | {"contact_point": None}, frames()["feet"][1]]}, {"more": 1},
])  # fmt: skip
def test_what_are_no_frames(change: dict[str, Any]) -> None:
    assert not are_frames(frames() | change, LEGS)
    assert not are_frames(None, LEGS) and not are_frames([], LEGS) and not are_frames(frames(), None)
