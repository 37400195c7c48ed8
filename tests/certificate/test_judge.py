"""A pick is judged by what the search found, and solved where the search did not find a good motion of it."""

from __future__ import annotations

import math

import pandas as pd
import pytest

from gaitflow.certificate.certificate import certify
from gaitflow.certificate.judge import Verdict, judge_picks, judge_plans
from gaitflow.core.task import Task


def at(speed: float) -> Task:
    return Task.of({"speed": speed, "cycle_duration": 0.5}, "held_out")


def costs(rows: list[tuple[float, str, float, float]]) -> pd.DataFrame:
    """Rows (speed, gait key, cost, excess), as `gait_costs` orders them."""
    frame = pd.DataFrame(rows, columns=["speed", "gait_key", "cost", "excess"])
    return frame.assign(cycle_duration=0.5, split="held_out", gait=frame["gait_key"])


def never(task: Task) -> float | None:
    raise AssertionError(f"{task} was solved anew")


def test_what_the_search_solved_well_is_not_solved_again() -> None:
    known = costs([(0.1, "a", 1.0, 0.0), (0.1, "b", 1.005, 0.005), (0.2, "b", 2.0, 0.0)])
    verdicts = judge_picks([at(0.1), at(0.1), at(0.2)], ["a", "b", "b"], known, never)
    assert [(one.excess, one.dearer, one.best) for one in verdicts] == [
        (0.0, False, "a"),
        (0.005, False, "a"),
        (0.0, False, "b"),
    ]


@pytest.mark.parametrize(("cost", "excess"), [(2.0, 0.5), (1.2, 0.2), (1.005, 0.005), (0.9, -0.1), (None, 0.5)])
def test_a_dear_pick_is_solved_from_the_map_too(cost: float | None, excess: float) -> None:
    known = costs([(0.1, "a", 1.0, 0.0), (0.1, "b", 1.5, 0.5)])
    [verdict] = judge_picks([at(0.1)], ["b"], known, lambda task: cost)
    assert verdict.excess == pytest.approx(excess) and not verdict.infeasible


@pytest.mark.parametrize(
    ("cost", "excess", "dearer"), [(1.2, 0.2, True), (1.005, 0.005, False), (0.9, -0.1, False), (None, math.inf, True)]
)
def test_a_pick_that_was_never_tried_is_solved(cost: float | None, excess: float, dearer: bool) -> None:
    [verdict] = judge_picks([at(0.1)], ["c"], costs([(0.1, "a", 1.0, 0.0)]), lambda task: cost)
    assert verdict.excess == pytest.approx(excess) and verdict.dearer is dearer
    assert verdict.infeasible is (cost is None)


def test_where_the_search_found_nothing_a_motion_of_the_pick_is_right() -> None:
    nothing = costs([])
    found, none = (judge_picks([at(0.1)], ["a"], nothing, lambda task, c=cost: c)[0] for cost in (3.0, None))
    assert found.best == "" and not found.dearer
    assert none.infeasible


def test_a_plan_is_judged_by_its_own_cost() -> None:
    known = costs([(0.1, "a", 1.0, 0.0), (0.1, "b", 1.2, 0.2)])
    plans = [("a", 1.005), ("a", 1.02), ("b", 1.001), ("b", 0.9), ("", None)]
    verdicts = judge_plans([at(0.1)] * len(plans), plans, known)
    assert [one.excess for one in verdicts] == pytest.approx([0.005, 0.02, 0.001, -0.1, math.inf])
    assert [one.dearer for one in verdicts] == [False, True, False, False, True]
    assert {one.best for one in verdicts} == {"a"}
    [found] = judge_plans([at(0.1)], [("a", 3.0)], costs([]))
    assert found.best == "" and not found.dearer, "where the search found nothing, a plan is right"


@pytest.mark.parametrize(("cost", "excess"), [(1.04, 0.02), (1.02, 0.0), (1.01, 0.0), (1.0, 0.0), (0.9, -0.1)])
def test_a_plan_of_the_best_gait_is_not_dearer_than_one_that_a_finer_mesh_ruled_out(cost: float, excess: float) -> None:
    known = costs([(0.1, "a", 1.02, 0.0), (0.1, "b", 1.0, 0.004)])  # b is cheaper on the scenario's mesh only
    [plan] = judge_plans([at(0.1)], [("a", cost)], known)
    assert plan.best == "a" and plan.excess == pytest.approx(excess, rel=0.05)
    [pick] = judge_picks([at(0.1)], ["c"], known, lambda task: cost)
    assert pick.excess == plan.excess


def test_a_certificate_counts_searched_and_planned_tasks() -> None:
    verdicts = [Verdict(at(0.1), "a", "a", 0.0)] * 97 + [
        Verdict(at(0.2), "a", "b", 0.3),
        Verdict(at(0.3), "a", "b", -0.2),
        Verdict(at(0.4), "a", "b", math.inf),
    ]
    selections = [*verdicts[:50], *[Verdict(at(0.2), "a", "b", 0.3)] * 50]
    found = certify(verdicts, selections, [True] * 899 + [False], asking=1, seed=4)
    assert (found.searched, found.dearer, found.planned, found.infeasible) == (100, 2, 1000, 2)
    assert (found.cheaper, found.worst_excess) == (1, 0.3)
    assert 0.02 < found.dearer_bound < 0.1 and 0.002 < found.infeasible_bound < 0.01
    assert found.selected_dearer == 50 and found.selected_bound is not None and 0.5 < found.selected_bound < 0.65
    later = certify(verdicts, selections, [True] * 900, asking=2, seed=4)
    assert later.dearer_bound > found.dearer_bound, "each further asking has less of the chance of error"
    assert "2 of 100 searched" in str(found)
