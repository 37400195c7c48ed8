"""Where a robot's links are, seen from the centre of mass and the contact points that a plan speaks of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class FootFrame:
    """A leg's name, the link of the robot's description that is its foot, and the contact point in its frame [3] m."""

    leg: str
    link: str
    contact_point: tuple[float, float, float]


@dataclass(frozen=True)
class Frames:
    """The frames of a robot's description (URDF): what ties a plan to its links.

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
        feet = [FootFrame(each["leg"], each["link"], tuple(each["contact_point"])) for each in found["feet"]]
        order = [leg["name"] for leg in robot["legs"]]
        return cls(
            str(found["base_link"]),
            tuple(found["com_in_base"]),
            tuple(sorted(feet, key=lambda foot: order.index(foot.leg))),
        )
