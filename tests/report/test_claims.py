from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest

from gaitflow.report.claims import CHECKS, EXACT, FIGURES, SCENARIOS, Claim, check_claims, claims_data, claims_markdown
from gaitflow.report.measures import verdict_of

EFFORT, VIBRATION, SLOPE = FIGURES["4a"], FIGURES["4b"], FIGURES["4c"]


def by_id(claims: tuple[Claim, ...]) -> dict[str, Claim]:
    return {claim.id: claim for claim in claims}


def rule_4b(speed: float, duration: float) -> str:
    """Section IV.A's words on Fig. 4b as a rule."""
    if speed <= 0.3:
        return "walking" if duration >= 1.4 else "gallop-walk"
    if speed <= 0.7:
        return "gallop-walk" if speed <= 0.5 or duration <= 1.4 else "gallop"
    return "gallop-bound" if duration >= 1.0 and speed <= 0.9 else "bounding"


def rule_4c(speed: float, duration: float) -> str:
    """Section IV.A's words on Fig. 4c as a rule."""
    if speed >= 0.9 and duration <= 0.8:
        return "gallop"
    if speed >= 0.9 and duration <= 1.0:
        return "pronking"
    return rule_4b(speed, duration)


@pytest.fixture(scope="module")
def maps(map_of, rule_4a) -> dict[str, pd.DataFrame]:
    return {EFFORT: map_of(rule_4a), VIBRATION: map_of(rule_4b), SLOPE: map_of(rule_4c)}


def test_maps_drawn_from_the_papers_words_meet_nearly_all_statements(maps) -> None:
    claims = check_claims(maps, {})
    assert [claim.id for claim in claims] == [check.id for check in CHECKS]
    # The rules above leave gallop-pronk out and keep no second region of Fig. 4a in 4b: the checks must see it.
    short = {claim.id: claim.verdict for claim in claims if claim.verdict not in ("holds", "not measured")}
    assert short == {"4-fig5": "holds in part", "4b-same": "does not"}


def test_a_map_of_one_gait_meets_none_but_the_trivial(map_of) -> None:
    claims = by_id(check_claims({name: map_of(lambda v, t: "bounding") for name in (EFFORT, VIBRATION, SLOPE)}, {}))
    held = {claim.id for claim in claims.values() if claim.verdict == "holds"}
    assert held == {"4a-bounding", "4a-fig5", "4b-bounding"}
    for name in ("4a-walking", "4a-gallop", "4a-small", "4a-pronking", "4-distinct", "4a-contiguous", "4c-gallop"):
        assert claims[name].verdict == "does not"


def test_a_statement_on_a_missing_scenario_says_what_it_needs(maps) -> None:
    claims = by_id(check_claims({EFFORT: maps[EFFORT]}, {}))
    assert claims["4b-same"].verdict == "not measured"
    assert claims["4b-same"].numbers == f"needs {VIBRATION} (Fig. 4b)"
    assert claims["4c-pronking"].numbers == f"needs {VIBRATION} (Fig. 4b) and {SLOPE} (Fig. 4c)"
    assert claims["4a-walking"].verdict == "holds"
    assert all(claim.verdict == "not measured" for claim in check_claims({}, {}))


def test_a_window_without_feasible_task_is_not_measured(map_of, rule_4a) -> None:
    claims = by_id(check_claims({EFFORT: map_of(rule_4a, speeds=np.array([1.1, 1.3]))}, {}))
    assert claims["4a-walking"].verdict == "not measured"


@pytest.mark.parametrize(("wins", "verdict"), [(14, "holds"), (12, "holds"), (11, "holds in part"), (5, "does not")])
def test_verdicts_follow_the_share_of_tasks(map_of, rule_4a, wins: int, verdict: str) -> None:
    labels = map_of(rule_4a)
    slow = labels.index[labels["speed"] <= 0.3]
    labels.loc[slow[wins:], "gait"] = "gallop"
    claim = by_id(check_claims({EFFORT: labels}, {}))["4a-walking"]
    assert claim.verdict == verdict
    assert claim.numbers.startswith(f"walking best at {wins} of 14 tasks")


def test_ties_are_reported_but_decide_nothing(map_of, rule_4a) -> None:
    labels = map_of(rule_4a)
    slow = labels["speed"] <= 0.3
    labels.loc[slow, "gait"] = "gallop-walk"
    labels["ties"] = [[gait, "walking"] for gait in labels["gait"]]
    claim = by_id(check_claims({EFFORT: labels}, {}))["4a-walking"]
    assert claim.verdict == "does not"
    assert "0 of 14 tasks (0%), 14 of 14 tasks (100%) with ties" in claim.numbers


def test_a_transition_gait_away_from_its_transition_does_not_hold(map_of, rule_4a) -> None:
    labels = map_of(rule_4a)
    labels.loc[labels["gait"] == "pronking", "gait"] = "gallop"
    labels.loc[(labels["speed"] == 2.3) & (labels["cycle_duration"] == 0.4), "gait"] = "pronking"
    claim = by_id(check_claims({EFFORT: labels}, {}))["4a-pronking"]
    assert (claim.verdict, claim.numbers[:15]) == ("does not", "0 of 1 tasks (0")


def test_scattered_gaits_are_not_contiguous(map_of) -> None:
    labels = map_of(lambda v, t: "gallop" if (round(v * 10) // 2 + round(t * 10) // 2) % 2 else "walking")
    assert by_id(check_claims({EFFORT: labels}, {}))["4a-contiguous"].verdict == "does not"


def test_equal_maps_are_not_distinct_but_keep_their_regions(maps) -> None:
    claims = by_id(check_claims({name: maps[EFFORT] for name in (EFFORT, VIBRATION, SLOPE)}, {}))
    assert claims["4-distinct"].verdict == "does not"
    assert claims["4b-same"].verdict == "holds"
    assert claims["4b-gallop-bound"].verdict == "does not"  # no increase


def test_maps_on_different_grids_are_compared_where_they_meet(map_of, rule_4a) -> None:
    few = map_of(rule_4b, speeds=np.array([0.1, 0.5, 0.9, 1.3]))
    claim = by_id(check_claims({EFFORT: map_of(rule_4a), VIBRATION: few}, {}))["4b-same"]
    assert "of 28 tasks" in claim.numbers


def test_maps_without_common_task_do_not_break_the_comparison(map_of, rule_4a) -> None:
    apart = map_of(rule_4b, speeds=np.array([5.0, 6.0]))
    claims = by_id(check_claims({EFFORT: map_of(rule_4a), VIBRATION: apart, SLOPE: apart}, {}))
    assert claims["4b-same"].verdict == "does not"
    assert claims["4-distinct"].verdict == "does not"


def test_rows_as_json_and_markdown(maps) -> None:
    claims = check_claims(maps, {})
    keys = {"id", "statement", "verdict", "numbers", "exact_verdict", "exact_numbers"}
    assert json.loads(json.dumps(claims_data(claims)))[0].keys() == keys
    lines = claims_markdown(claims).splitlines()
    assert len(lines) == 2 + len(claims)
    assert {line.count(" | ") for line in lines} == {5}


def test_a_bar_in_a_text_does_not_break_the_markdown_table() -> None:
    row = claims_markdown([Claim("x", "a | b", "holds", "1", "does not", "2")]).splitlines()[-1]
    assert row == "| x | a \\| b | holds | does not | 1 | 2 |"


def test_the_exact_maps_are_measured_beside_eulers(maps, map_of) -> None:
    assert set(SCENARIOS) == {*FIGURES.values(), *EXACT.values()}
    exact = {name: map_of(lambda v, t: "bounding") for name in EXACT.values()}
    claims, alone = by_id(check_claims(maps | exact, {})), by_id(check_claims(maps, {}))
    assert (claims["4a-walking"].verdict, claims["4a-walking"].exact_verdict) == ("holds", "does not")
    assert (claims["4b-bounding"].exact_verdict, alone["4b-bounding"].exact_verdict) == ("holds", "not measured")
    assert alone["4b-bounding"].exact_numbers == f"needs {EXACT['4b']} (Fig. 4b)"
    assert all(claims[key].verdict == alone[key].verdict for key in claims)


def test_where_time_reversal_merges_two_gaits_their_names_count_as_one(map_of, rule_4a) -> None:
    def merged(speed: float, duration: float) -> str:
        gait = rule_4a(speed, duration)
        return "gallop-pronk" if gait == "pronking" else gait

    labels = map_of(merged)
    claim = by_id(check_claims({EFFORT: labels, EXACT["4a"]: labels}, {}))["4a-pronking"]
    assert (claim.verdict, claim.exact_verdict) == ("does not", "holds")


def test_nothing_to_count_does_not_hold() -> None:
    assert verdict_of(float("nan")) == "does not"
    assert (verdict_of(0.8), verdict_of(0.4), verdict_of(0.399)) == ("holds", "holds in part", "does not")


def test_flight_and_the_number_of_gaits(map_of, rule_4a, maps) -> None:
    fast_flies = map_of(lambda v, t: "gallop" if v > 1.5 else "walking" if v < 1.0 else "pronking")
    claims = by_id(check_claims(maps | {FIGURES["7"]: fast_flies}, {}))
    assert [claims[key].verdict for key in ("7-no-flight", "7-flight", "7-running", "7-more")] == [
        "holds",
        "holds",
        "does not",
        "does not",
    ]
    assert claims["7-no-flight"].numbers == "no flight at 28 of 28 tasks (100%)"
    bounding = by_id(check_claims({FIGURES["7"]: map_of(lambda v, t: "bounding")}, {}))
    assert bounding["7-no-flight"].verdict == "does not" and bounding["7-flight"].verdict == "holds"


def test_motions_are_measured_where_they_are_given(maps, solution_of) -> None:
    region = [solution_of(speed, 0.6, "gallop") for speed in (0.9, 1.1, 1.3)]
    claims = by_id(check_claims(maps, {EFFORT: {"gallop": region, "walking": []}}))
    assert claims["6-similar-4a"].verdict != "not measured" and "gallop" in claims["6-similar-4a"].numbers
    assert claims["6-similar-4b"].numbers == f"needs {VIBRATION} (Fig. 4b)"
