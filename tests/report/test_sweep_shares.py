"""Shares of robots that keep a statement, and the parameter that decides it, on tables whose answer is known."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from gaitflow.config.sweep import Sweep
from gaitflow.report.report import png_of
from gaitflow.report.sweep_chart import draw_sweep
from gaitflow.report.sweep_page import RuleOfMotion, SweepResult, share_texts, sweep_data, sweep_page
from gaitflow.report.sweep_shares import statements_kept, sweep_shares, sweep_verdicts

ROBOTS = 40
SWEEP = Sweep.from_data(
    {"name": "made", "samples": ROBOTS, "ranges": {"mass": [1.0, 2.0], "inertia": {"factor": [0.5, 2.0]}}}, "test"
)


@pytest.fixture(scope="module")
def parameters() -> pd.DataFrame:
    generator = np.random.default_rng(3)
    return pd.DataFrame({"mass": generator.uniform(1, 2, ROBOTS), "inertia": generator.uniform(0.5, 2, ROBOTS)})


@pytest.fixture(scope="module")
def verdicts(parameters: pd.DataFrame, map_of: Callable[..., pd.DataFrame], rule_4a) -> pd.DataFrame:
    """Fig. 4a as the paper has it for robots of less than 1.4 kg, one gait everywhere for the others."""
    bounding = map_of(lambda speed, duration: "bounding")
    frames = {number: map_of(rule_4a) if mass < 1.4 else bounding for number, mass in parameters["mass"].items()}
    return sweep_verdicts({"4a": frames}, exact=False)


def test_only_statements_that_the_figures_suffice_for_are_asked(verdicts: pd.DataFrame) -> None:
    assert "4a-walking" in verdicts and "4a-contiguous" in verdicts
    assert not [name for name in verdicts if name.startswith(("4b", "4c", "4-", "6-", "7", "10"))]


def test_shares_count_robots_and_have_an_exact_interval(verdicts: pd.DataFrame, parameters: pd.DataFrame) -> None:
    light = int((parameters["mass"] < 1.4).sum())
    share = sweep_shares(verdicts, parameters)["4a-walking"]
    assert (share.robots, share.holds, share.in_part) == (ROBOTS, light, 0)
    assert share.low < light / ROBOTS < share.high
    everywhere = sweep_shares(verdicts, parameters)["4a-bounding"]
    assert everywhere.holds == ROBOTS and everywhere.high == 1.0
    assert everywhere.low == pytest.approx(0.025 ** (1 / ROBOTS)), "Clopper and Pearson's, of n successes in n"


def test_the_parameter_that_decides_is_found_and_no_other(verdicts: pd.DataFrame, parameters: pd.DataFrame) -> None:
    share = sweep_shares(verdicts, parameters)["4a-walking"]
    assert share.decided_by == ("mass",)
    assert share.influences["mass"].correlation < -0.7 and share.influences["mass"].p < 0.001
    assert share.influences["inertia"].p > 0.05
    assert sweep_shares(verdicts, parameters)["4a-bounding"].influences == {}, "all robots agree: nothing decides"


def test_by_chance_a_parameter_seldom_decides() -> None:
    generator = np.random.default_rng(0)
    parameters = pd.DataFrame(generator.uniform(size=(48, 9)), columns=[f"p{i}" for i in range(9)])
    words = np.array(["does not", "holds in part", "holds"])
    verdicts = pd.DataFrame(words[generator.integers(0, 3, size=(48, 100))], columns=[f"s{i}" for i in range(100)])
    least = [min(one.p for one in share.influences.values()) for share in sweep_shares(verdicts, parameters).values()]
    assert 1 <= sum(p < 0.1 for p in least) <= 20, "ten are expected of a hundred, whatever the number of parameters"


def test_what_cannot_be_measured_is_left_out_of_the_share(parameters: pd.DataFrame) -> None:
    verdicts = pd.DataFrame({"one": ["holds", "not measured", "does not"], "none": ["not measured"] * 3})
    shares = sweep_shares(verdicts, parameters.head(3))
    assert (shares["one"].robots, shares["one"].holds) == (2, 1)
    assert (shares["none"].robots, shares["none"].low, shares["none"].high) == (0, 0.0, 1.0)


def test_the_robots_that_keep_most_come_first() -> None:
    verdicts = pd.DataFrame(
        {"a": ["holds", "holds", "does not"], "b": ["does not", "holds in part", "holds"]}, index=[7, 8, 9]
    )
    kept = statements_kept(verdicts)
    assert list(kept.index) == [8, 7, 9]
    assert list(kept.loc[8]) == [1, 1]


def test_robots_that_a_figure_lacks_are_not_asked(map_of, rule_4a) -> None:
    labels = map_of(rule_4a)
    both = sweep_verdicts({"4a": {0: labels, 1: labels}, "4b": {1: labels}}, exact=True)
    assert list(both.index) == [1] and "4b-same" in both
    with pytest.raises(ValueError, match="no robot has labels for every figure"):
        sweep_verdicts({"4a": {0: labels}, "4b": {1: labels}}, exact=True)


def test_a_robot_that_nothing_is_feasible_for_breaks_nothing(map_of, rule_4a) -> None:
    labels = map_of(rule_4a)
    nothing = labels.assign(status="infeasible", gait="", gait_key="", ties=[[] for _ in range(len(labels))])
    verdicts = sweep_verdicts({figure: {0: labels, 1: nothing} for figure in ("4a", "4b", "4c")}, exact=False)
    assert verdicts.loc[1, "4a-walking"] == "not measured"
    assert set(verdicts.loc[1]) == {"not measured", "does not"}


def test_the_document_says_the_same_in_words_data_and_picture(
    verdicts: pd.DataFrame, parameters: pd.DataFrame, scenario
) -> None:
    rule = RuleOfMotion("forward Euler", {"4a": scenario}, verdicts, {"4a-walking": "holds in part"})
    result = SweepResult(SWEEP, parameters, [rule])
    share = result.shares["forward Euler"]["4a-walking"]
    data = json.loads(json.dumps(sweep_data(result), allow_nan=False))
    told = share_texts(data)["forward Euler"]["4a-walking"]
    assert told == f"{share.holds} of {ROBOTS} ({share.low:.0%} to {share.high:.0%})".replace("%", " %").replace(
        " % to", " to"
    )
    page = sweep_page(result, "made.png")
    (row,) = [line for line in page.splitlines() if line.startswith("| 4a-walking ")]
    assert f"| {told} | 0 | holds in part | mass (-0." in row
    assert all(len(line) <= 120 or line.startswith("|") for line in page.splitlines())
    assert len(data["robots"]) == ROBOTS and len(data["rules"][0]["robots"]) == ROBOTS
    assert png_of(draw_sweep(result.shares, "made")).startswith(b"\x89PNG")
    agreed = {"forward Euler": sweep_shares(verdicts[["4a-bounding"]], parameters)}
    assert png_of(draw_sweep(agreed, "nothing decides")).startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="no statement was asked"):
        draw_sweep({"forward Euler": {}}, "nothing")
