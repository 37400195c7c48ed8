"""Golden iteration counts of the published maps: a change of the fast method shows here before any clock does."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitflow.runtime import GaitMap

MODELS = Path(__file__).parents[2] / "models"
SPREAD = 1  # iterations by which another machine's rounding may differ
# scenario: (speed m/s, cycle duration s, gait, iterations), tasks that are no nodes of the map's atlas.
GOLDEN = {
    "half-cheetah-flat-effort": [
        (0.386, 1.396, "gallop-walk", 6),
        (0.892, 1.144, "gallop-pronk", 7),
        (1.398, 0.892, "gallop", 5),
        (1.904, 0.64, "gallop", 6),
    ],
    "half-cheetah-flat-vibration": [
        (0.386, 1.396, "gallop-walk", 6),
        (0.892, 1.144, "F 001 / H 100", 5),
        (1.398, 0.892, "bounding", 4),
        (1.904, 0.64, "bounding", 5),
    ],
    "half-cheetah-slope20-vibration": [
        (0.892, 1.144, "gallop-bound", 7),
        (1.398, 0.892, "bounding", 5),
        (1.904, 0.64, "bounding", 6),
    ],
    "anymal-flat-vibration": [
        (0.295, 0.898, "walking trot", 6),
        (1.33, 0.52, "three-beat walk 0001/0110/1100/0001", 6),
    ],
}


@pytest.mark.parametrize("scenario", GOLDEN)
def test_plans_take_as_few_iterations_as_when_the_map_was_published(scenario: str) -> None:
    gait_map = GaitMap.load(MODELS / scenario / "1.1.0")
    for speed, cycle_duration, gait, iterations in GOLDEN[scenario]:
        plan = gait_map.plan(speed, cycle_duration)
        assert (plan.gait, plan.path, plan.feasible) == (gait, "fast", True), (speed, cycle_duration)
        assert abs(plan.iterations - iterations) <= SPREAD, (speed, cycle_duration, plan.iterations)
