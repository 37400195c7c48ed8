"""Where a robot's links are, relative to the centre of mass and the contact points of a plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

LONGEST_NAME = 200
FARTHEST = 1e3  # m


@dataclass(frozen=True)
class FootFrame:
    """The foot of a leg: the link of the description whose origin is the foot of every plan.

    contact_point [3] m, in the link's frame, is where the foot touches the ground in the standing pose. If that is not
    the link's origin, the real ground is that much lower than the plan's.
    """

    leg: str
    link: str
    contact_point: tuple[float, float, float]


@dataclass(frozen=True)
class Frames:
    """The frames of a robot's description (URDF), which connect a plan with the robot's links.

    base_link is the link whose axes are the base frame's; com_in_base [3] m is the centre of mass in it, of the whole
    robot in its standing pose. feet are in the order of the legs in every array of the plan.
    """

    base_link: str
    com_in_base: tuple[float, float, float]
    feet: tuple[FootFrame, ...]

    @classmethod
    def of(cls, scenario: Mapping[str, Any]) -> Frames | None:
        """The frames in a scenario's JSON data; None where its robot has none."""
        robot = scenario["robot"]
        found = robot.get("frames")
        if found is None:
            return None
        feet = tuple(FootFrame(each["leg"], each["link"], _vector(each["contact_point"])) for each in found["feet"])
        return cls(str(found["base_link"]), _vector(found["com_in_base"]), feet)


def are_frames(data: object, legs: object) -> bool:
    """Whether plain data, which anybody may have written, are the frames of a robot with these legs."""
    if not isinstance(data, Mapping) or set(data) != {"base_link", "com_in_base", "feet"}:
        return False
    feet = data["feet"]
    if not isinstance(feet, list) or not isinstance(legs, list) or len(feet) != len(legs):
        return False
    return (
        _is_name(data["base_link"])
        and _is_vector(data["com_in_base"])
        and all(
            isinstance(foot, Mapping)
            and set(foot) == {"leg", "link", "contact_point"}
            and foot["leg"] == leg["name"]
            and _is_name(foot["link"])
            and _is_vector(foot["contact_point"])
            for foot, leg in zip(feet, legs, strict=True)
        )
    )


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST_NAME


def _is_vector(value: object) -> bool:
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(each, int | float) and not isinstance(each, bool) and abs(each) < FARTHEST for each in value)
    )


def _vector(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return float(x), float(y), float(z)
