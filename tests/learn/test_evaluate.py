"""Regret, infeasible picks and the rule that chooses, on numbers worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from gaitflow.learn.evaluate import Quality, choose, judge, judge_order

CLASSES = ("gallop", "trot", "walk")
COSTS = {0.1: {"walk": 1.0, "gallop": 1.0005, "trot": 4.0}, 0.2: {"walk": 2.0, "trot": 3.0}, 0.3: {"trot": 5.0}}
PICKS = {0.1: "gallop", 0.2: "trot", 0.3: "walk"}  # a tie, 50 % dearer, infeasible


def frames() -> tuple[pd.DataFrame, pd.DataFrame]:
    costs = pd.DataFrame(
        [
            {"speed": v, "cycle_duration": 1.0, "split": "grid", "gait": gait, "excess": cost / min(row.values()) - 1}
            for v, row in COSTS.items()
            for gait, cost in row.items()
        ]
    )
    labels = pd.DataFrame(
        {
            "speed": list(COSTS),
            "cycle_duration": 1.0,
            "split": "grid",
            "cost": [1.0, 2.0, 5.0],
            "ties": [["walk", "gallop"], ["walk"], ["trot"]],
            "label": ["walk", "walk", "trot"],
        }
    )
    return labels, costs


def one_hot(picks: dict[float, str], second: str) -> np.ndarray:
    rows = [[1.0 * (gait == pick) + 0.5 * (gait == second) for gait in CLASSES] for pick in picks.values()]
    return np.array(rows)


def test_quality_by_hand() -> None:
    labels, costs = frames()
    quality = judge(one_hot(PICKS, second="gallop"), CLASSES, labels, costs)
    assert quality.tasks == 3
    assert quality.accuracy == 0.0
    assert quality.macro_f1 == 0.0
    assert quality.top1_beyond_ties == pytest.approx(1 / 3)
    assert quality.regret_mean == pytest.approx((0.0005 + 0.5) / 2)
    assert quality.regret_p95 == pytest.approx(0.0005 + 0.95 * 0.4995)
    assert quality.infeasible_rate == pytest.approx(1 / 3)
    assert quality.infeasible_top2 == pytest.approx(1 / 3)  # gallop is infeasible there as well
    rescued = judge(one_hot(PICKS, second="trot"), CLASSES, labels, costs)
    assert rescued.infeasible_rate == pytest.approx(1 / 3)
    assert rescued.infeasible_top2 == 0.0


def test_an_order_is_judged_as_the_probabilities_that_make_it() -> None:
    labels, costs = frames()
    probabilities = one_hot(PICKS, second="trot")
    order = np.argsort(-probabilities, axis=1)
    assert judge_order(order, CLASSES, labels, costs) == judge(probabilities, CLASSES, labels, costs)


def test_picks_that_are_the_labels_are_perfect() -> None:
    labels, costs = frames()
    picks = dict(zip(COSTS, labels["label"], strict=True))
    quality = judge(one_hot(picks, second="gallop"), CLASSES, labels, costs)
    assert quality == Quality(3, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0)


def test_a_best_gait_that_the_classifier_does_not_know_still_sets_the_least_cost() -> None:
    labels, costs = frames()
    quality = judge(np.array([[0.1, 0.9], [0.1, 0.9], [0.1, 0.9]]), ("gallop", "trot"), labels, costs)
    assert quality.regret_mean == pytest.approx((3.0 + 0.5 + 0.0) / 3)
    assert quality.accuracy == pytest.approx(1 / 3)


def test_only_infeasible_picks_have_no_regret_and_no_tasks_have_no_quality() -> None:
    labels, costs = frames()
    lost = judge(np.array([[0.4, 0.0, 0.6]]), CLASSES, labels.iloc[2:], costs)
    assert (lost.infeasible_rate, lost.infeasible_top2) == (1.0, 1.0)
    assert math.isnan(lost.regret_mean)
    nothing = judge(np.empty((0, 3)), CLASSES, labels.iloc[:0], costs)
    assert nothing.tasks == 0
    assert math.isnan(nothing.accuracy)


GOOD = Quality(100, 0.9, 0.9, 0.95, 0.01, 0.05, 0.02, 0.0)


@pytest.mark.parametrize(
    ("second", "winner"),
    [
        (GOOD, "first"),  # equal: the faster one
        (replace(GOOD, accuracy=1.0), "first"),  # accuracy is not asked
        (replace(GOOD, regret_mean=0.0095), "first"),  # within the tie tolerance
        (replace(GOOD, regret_mean=0.005), "second"),
        (replace(GOOD, infeasible_rate=0.01), "first"),  # one task
        (replace(GOOD, infeasible_rate=0.0, regret_mean=0.5), "second"),  # two tasks, whatever the regret
        (replace(GOOD, infeasible_rate=0.03, regret_mean=0.005), "second"),
        (replace(GOOD, regret_mean=float("nan")), "first"),  # all picks infeasible
    ],
)
def test_the_rule(second: Quality, winner: str) -> None:
    assert choose({"first": GOOD, "second": second}, tie_tolerance=1e-3) == winner


def test_the_rule_when_no_method_has_a_feasible_pick() -> None:
    hopeless = replace(GOOD, regret_mean=float("nan"), infeasible_rate=1.0)
    assert choose({"first": hopeless, "second": hopeless}, tie_tolerance=1e-3) == "first"
