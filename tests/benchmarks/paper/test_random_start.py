from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.paper.random_start import METHODS, PlanAndFixedGait
from gaitflow.runtime import GaitMap

TASK = {"speed": 1.25, "cycle_duration": 0.55}


def test_all_ways_start_from_the_same_task_and_are_timed_by_both_clocks(pristine: Path) -> None:
    ways = PlanAndFixedGait(str(pristine), {"speed": 1.1, "cycle_duration": 0.7})
    found = {method: ways(method, TASK, 0) for method in METHODS}
    assert len({frozenset(result) for result in found.values()}) == 1, "each tells the same"
    picked, plan = GaitMap.load(pristine).select(**TASK), GaitMap.load(pristine).plan(**TASK)
    for method, result in found.items():
        assert result["wall_s"] > 0 and result["cpu_s"] > 0, method
        assert (result["cost"] is None) == (result["status"] != "solved"), method
        assert result["gait"] == (plan.gait if method == "plan" else picked.gait), method
    assert (found["plan"]["cost"], found["plan"]["iterations"]) == (plan.cost, plan.iterations)
    assert found["bounds_mean"]["cost"] == pytest.approx(plan.cost, rel=1e-4)
