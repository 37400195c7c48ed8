from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks.paper.table import draw_tasks, judge, off_grid_places, summarise
from benchmarks.paper.table1 import METHODS
from gaitflow.config.scenario import Scenario
from gaitflow.core.domain import Domain

GALLOP, WALKING = "0011/0110", "0111/1101"
REFERENCE = {
    "speed": 1.0, "cycle_duration": 0.6, "method": "patterns", "seed": None, "gait": "gallop", "pattern": GALLOP,
    "cost": 100.0, "costs": {GALLOP: 100.0, WALKING: 120.0, "0011/1110": 101.0}, "counts": {"solved": 3},
    "violation": 1e-9, "status": "solved", "wall_s": 4.0, "whole_wall_s": 5.0, "cpu_s": 4.0, "whole_cpu_s": 5.0,
}  # fmt: skip


def row(
    method: str, cost: float | None, time: float, pattern: str | None = GALLOP, gait: str | None = "gallop"
) -> dict:
    return {
        "speed": 1.0, "cycle_duration": 0.6, "method": method, "seed": 0, "gait": gait, "pattern": pattern,
        "cost": cost, "violation": 1e-9, "status": "solved" if cost else "failed", "wall_s": time, "cpu_s": time,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("found", "consistent", "own", "better"),
    [
        (row("minlp", 100.05, 1.0), True, True, False),
        (row("minlp", 100.2, 1.0), False, False, False),
        (row("minlp", 99.0, 1.0), True, True, True),
        (row("minlp", 100.05, 1.0, "0110/1100"), True, True, False),  # the same cycle, cut elsewhere
        (row("minlp", 120.0, 1.0, WALKING, "walking"), False, True, False),
        (row("minlp", 100.0, 1.0, WALKING, "walking"), True, True, False),
        (row("minlp", 101.05, 1.0, "0011/1110"), True, True, False),  # the best gait, its phases split elsewhere
        (row("minlp", 101.05, 1.0, "0011/1110", "another"), False, True, False),
        (
            row("minlp", 100.0, 1.0, "0001/0100", "bounding"),
            True,
            False,
            False,
        ),  # nothing known of its pattern
        (row("minlp", None, 1.0), False, False, False),
        (row("minlp", None, 1.0, None, None), False, False, False),
    ],
)
def test_consistency_is_with_the_search_and_with_the_best_of_the_pattern(
    scenario: Scenario, found: dict, consistent: bool, own: bool, better: bool
) -> None:
    _, judged = judge([REFERENCE, found], scenario)
    assert (judged["consistent"], judged["consistent_pattern"], judged["better"]) == (consistent, own, better)
    assert judged["successful"] == (found["cost"] is not None)
    assert (judged["reference_cost"], judged["reference_gait"]) == (100.0, "gallop")


def test_nothing_is_consistent_with_a_search_that_found_nothing(scenario: Scenario) -> None:
    nothing = REFERENCE | {"cost": None, "costs": {}, "gait": None, "pattern": None, "status": "infeasible"}
    reference, judged = judge([nothing, row("minlp", 100.0, 1.0)], scenario)
    assert not reference["successful"]
    assert judged["successful"]
    assert not judged["consistent"] and not judged["consistent_pattern"] and not judged["better"]


def test_summary_counts_failures_and_their_time(scenario: Scenario) -> None:
    rows = [REFERENCE]
    rows += [row("minlp", None, 300.0), row("minlp", 100.0, 30.0), row("minlp", 90.0, 60.0)]
    rows += [row("bigm_random", 130.0, 2.0), row("bigm_random", None, 4.0)]
    rows += [row(method, 100.0, 0.05) | {"build_s": 0.7} for method in METHODS[2:5]]
    summary = summarise(judge(rows, scenario))
    assert list(summary) == list(METHODS)
    for method in summary.values():
        assert {"time_mean_s", "time_std_s", "successful", "consistent", "runs"} <= set(method)
    minlp = summary["minlp"]
    assert minlp["time_mean_s"] == 130.0
    assert minlp["time_std_s"] == pytest.approx(math.sqrt((170**2 + 100**2 + 70**2) / 2))
    assert (minlp["successful"], minlp["consistent"], minlp["better"], minlp["runs"]) == (2, 2, 1, 3)
    assert (summary["bigm_random"]["successful"], summary["bigm_random"]["consistent"]) == (1, 0)
    assert summary["bigm_random"]["runs"] == 2
    assert summary["bounds_mean"]["time_std_s"] == 0.0
    assert summary["bounds_mean"]["build_s"] == 0.7
    assert summary["patterns"]["consistent"] is None
    assert summary["patterns"]["time_mean_s"] == 5.0, "all of the search, not its solver calls alone"


def _domain(feasible: list[list[bool]]) -> Domain:
    axes = {"speed": (0.1, 0.5, 0.9)[: len(feasible)], "cycle_duration": (0.4, 0.8)}
    return Domain(axes, np.array(feasible))


def test_places_lie_in_the_domain_and_off_its_grid() -> None:
    domain = _domain([[True, True], [True, True], [False, True]])
    drawn = off_grid_places(domain, 20, 0)
    assert drawn == off_grid_places(domain, 20, 0)
    assert drawn[:5] == off_grid_places(domain, 5, 0), "more tasks keep those drawn before"
    assert len({tuple(place.values()) for place in drawn}) == 20
    for place in drawn:
        assert domain.contains(place)
        assert place["speed"] < 0.5
        assert place["speed"] not in domain.axes["speed"]
    assert off_grid_places(domain, 5, 1) != drawn[:5]


def test_an_axis_of_one_value_has_no_other() -> None:
    domain = Domain({"speed": (0.1, 0.9), "cycle_duration": (0.4,)}, np.ones((2, 1), dtype=bool))
    drawn = off_grid_places(domain, 3, 0)
    assert {place["cycle_duration"] for place in drawn} == {0.4}


def test_a_domain_without_inside_is_refused() -> None:
    with pytest.raises(ValueError, match="found 0 of 3 tasks"):
        off_grid_places(_domain([[True, False], [False, True]]), 3, 0)


def test_an_artifact_of_another_problem_is_refused(scenario: Scenario, pristine: Path) -> None:
    with pytest.raises(ValueError, match="was made for quickstart with other settings"):
        draw_tasks(scenario, pristine, 1, 0)
    with pytest.raises(ValueError, match="tasks = 0"):
        draw_tasks(scenario, pristine, 0, 0)
