from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.paper.fixed_gait import METHODS, FixedGait, scenario_of
from gaitflow.runtime import GaitMap

TASK = {"speed": 1.25, "cycle_duration": 0.55}


@pytest.fixture(scope="module")
def fixed_gait(pristine: Path) -> FixedGait:
    return FixedGait(str(pristine), {"speed": 1.1, "cycle_duration": 0.7})


@pytest.fixture(scope="module")
def results(fixed_gait: FixedGait) -> dict[str, dict]:
    return {method: fixed_gait(method, TASK, 0) for method in METHODS}


def test_all_methods_take_the_gait_that_the_map_picks(results: dict[str, dict], pristine: Path) -> None:
    choice = GaitMap.load(pristine).select(**TASK)
    assert choice.gait == "gallop"
    for result in results.values():
        assert (result["gait"], result["pattern"]) == (choice.gait, choice.pattern)


def test_each_is_judged_by_our_check_and_timed(results: dict[str, dict]) -> None:
    for method, result in results.items():
        assert result["wall_s"] > 0, method
        assert 0 < result["build_s"] < 60, method
        assert (result["cost"] is not None) == (result["status"] == "solved"), method
        if result["status"] == "solved":
            assert result["violation"] <= 1e-6, method
    assert results["bounds_mean"]["status"] == results["bounds_mean_dual"]["status"] == "solved"
    assert results["bounds_mean"]["cost"] == pytest.approx(results["bounds_mean_dual"]["cost"], rel=1e-5)


def test_the_dual_start_is_what_plan_does(results: dict[str, dict], pristine: Path) -> None:
    plan = GaitMap.load(pristine).plan(**TASK)
    assert (plan.cost, plan.iterations) == (
        results["bounds_mean_dual"]["cost"],
        results["bounds_mean_dual"]["iterations"],
    )


def test_random_starts_follow_the_seed(fixed_gait: FixedGait, results: dict[str, dict]) -> None:
    again = fixed_gait("bounds_random", TASK, 0)
    other = fixed_gait("bounds_random", TASK, 2)
    assert (again["iterations"], again["cost"]) == (
        results["bounds_random"]["iterations"],
        results["bounds_random"]["cost"],
    )
    assert (other["iterations"], other["violation"]) != (again["iterations"], again["violation"])


def test_the_artifact_knows_its_scenario(pristine: Path) -> None:
    assert scenario_of(pristine).transcription.knots_per_phase == 4
