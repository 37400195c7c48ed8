"""Plans of other processes are those of this one, and are counted as they come."""

from __future__ import annotations

from pathlib import Path

import psutil
import pytest

from gaitflow.execute.map_processes import Asked, Planned, plan_all
from gaitflow.runtime import GaitMap

MAP = Path(__file__).parents[2] / "models" / "half-cheetah-exact-vibration"


def started() -> set[psutil.Process]:
    """Processes of this one that were started as ours are."""
    return {child for child in psutil.Process().children() if "spawn_main" in " ".join(child.cmdline())}


def test_plans_are_the_same_whoever_makes_them() -> None:
    gait = GaitMap.load(MAP).gaits[0].name
    asked: list[Asked] = [({"speed": speed, "cycle_duration": 0.6}, None) for speed in (0.4, 0.9, 1.4)]
    asked.append(({"speed": 0.9, "cycle_duration": 0.6}, gait))
    before, here, there = started(), list[Planned](), list[Planned]()
    alone, together = plan_all(MAP, asked, 1, here.append), plan_all(MAP, asked, 2, there.append)
    assert together == alone and alone[-1][0] == gait
    assert all(cost is not None and cost > 0 for _, cost in alone)
    assert here == there == alone
    assert started() <= before, "they have ended"


def test_a_plan_without_a_motion_has_no_cost() -> None:
    fastest = {"speed": 2.3, "cycle_duration": 0.8}  # beyond what a walking gait reaches
    assert plan_all(MAP, [(fastest, "gallop-walk")], 2) == [("gallop-walk", None)]


def test_what_a_process_raises_is_raised_here() -> None:
    with pytest.raises(ValueError, match="yaw_rate"):
        plan_all(MAP, [({"speed": 0.9, "cycle_duration": 0.6, "yaw_rate": 0.1}, None)] * 2, 2)
