from __future__ import annotations

import json
from pathlib import Path

from benchmarks.online.plan_times import PlanTimes, warm_up
from gaitflow.runtime import GaitMap

TASKS = [{"speed": 0.45, "cycle_duration": 0.75}, {"speed": 1.25, "cycle_duration": 0.7}]


def test_every_call_is_timed_and_told_as_plan_and_select_do(pristine: Path) -> None:
    told = PlanTimes(str(pristine))(TASKS)
    gait_map = GaitMap.load(pristine)
    assert (len(told["rows"]), len(told["select_us"])) == (2, 2)
    assert all(0 < each < 1e5 for each in told["select_us"])
    assert told["load_s"] > 0 and told["warm_up_s"] > 0
    for row, task in zip(told["rows"], TASKS, strict=True):
        plan, choice = gait_map.plan(**task), gait_map.select(**task)
        assert task.items() <= row.items()
        assert (row["gait"], row["path"], row["first"]) == (plan.gait, plan.path, choice.gait)
        assert (row["cost"], row["violation"], row["feasible"]) == (plan.cost, plan.violation, plan.feasible)
        assert (row["picked"], row["probability"]) == (choice.gait, choice.probability)
        parts = row["select_ms"] + row["predict_ms"] + row["refine_ms"]
        assert 0 < parts <= row["wall_ms"]
        assert row["cpu_ms"] > 0
    json.dumps(told, allow_nan=False)


def test_each_gait_that_is_picked_somewhere_is_planned_once(pristine: Path) -> None:
    asked: list[dict[str, float]] = []

    class Counted(GaitMap):
        def plan(self, **task: float) -> None:  # type: ignore[override]
            asked.append(task)

    gait_map = Counted.load(pristine)
    assert warm_up(gait_map) == len(asked) == 2
    assert sorted(str(gait_map.select(**task).gait) for task in asked) == ["gallop", "walking"]
