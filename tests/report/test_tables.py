from __future__ import annotations

import math
from dataclasses import replace
from typing import get_args

import numpy as np

from gaitflow.core.check import between_knots, violations
from gaitflow.report.tables import (
    between_knots_table,
    check_table,
    effort_table,
    gait_table,
    learning_table,
    number,
    percent,
    provenance_table,
    tie_table,
    unresolved_table,
    unsolved_table,
)
from gaitflow.search.solution import Status


def as_dict(table) -> dict[str, dict[str, str]]:
    return {row[0]: dict(zip(table.columns, row, strict=True)) for row in table.rows}


def test_gaits_with_what_they_win_cost_and_lead_by(labels) -> None:
    rows = as_dict(gait_table(labels, ("F", "H")))
    assert list(rows)[:2] == ["walking", "gallop-walk"]
    walking = labels[labels["gait"] == "walking"]
    assert rows["walking"]["grid tasks"] == "13"
    assert rows["walking"]["held-out tasks"] == str((walking["split"] == "held_out").sum())
    assert rows["walking"]["cost"] == f"{number(walking['cost'].min())} to {number(walking['cost'].max())}"
    assert rows["walking"]["mean margin"] == percent(walking["margin"].mean())
    assert rows["walking"]["pattern"] == "F 0111 / H 1101"
    assert sum(int(row["grid tasks"]) for row in rows.values()) == 83


def test_a_single_cost_is_no_range(labels) -> None:
    one = labels[labels["gait"] == "gallop"].iloc[:1]
    assert as_dict(gait_table(one, ("F", "H")))["gallop"]["cost"] == number(one["cost"].iloc[0])


def test_an_infinite_margin_is_no_part_of_the_mean(labels) -> None:
    one = labels.copy()
    one.loc[one["gait"] == "bounding", "margin"] = math.inf
    one.loc[one.index[one["gait"] == "bounding"][0], "margin"] = 0.25
    assert as_dict(gait_table(one, ("F", "H")))["bounding"]["mean margin"] == "25 %"
    one.loc[one["gait"] == "bounding", "margin"] = math.inf
    assert as_dict(gait_table(one, ("F", "H")))["bounding"]["mean margin"] == "–"


def test_how_sure_labels_are_is_shown_when_known(labels, space) -> None:
    assert "worst cost error" not in gait_table(labels, ("F", "H")).columns
    assert unresolved_table(labels, space).rows == ()
    gallop = labels["gait"] == "gallop"
    known = labels.assign(cost_error=np.where(gallop, 0.02, 0.001), resolved=~gallop | (labels["speed"] > 1.5))
    rows = as_dict(gait_table(known, ("F", "H")))
    assert (rows["gallop"]["worst cost error"], rows["walking"]["worst cost error"]) == ("2 %", "0.1 %")
    assert rows["walking"]["labels not resolved"] == "0"
    open_ = int((gallop & (labels["speed"] <= 1.5)).sum())
    assert rows["gallop"]["labels not resolved"] == str(open_) != "0"
    table = unresolved_table(known, space)
    assert len(table.rows) == open_
    first = as_dict(table)["0.9"]
    assert (first["gait"], first["runner-up"], first["cost error"]) == ("gallop", "walking", "2 %")


def test_ties_and_tasks_without_a_gait_are_listed_one_by_one(labels, space) -> None:
    ties = tie_table(labels, space)
    assert len(ties.rows) == (labels["ties"].map(len) > 1).sum()
    assert ties.rows[0] == ("0.1", "0.4", "grid", "walking, gallop-walk", "0.04 %", "walking")
    assert unsolved_table(labels, space).rows == (("0.1", "1.6", "grid", "infeasible"),)


def test_effort_counts_every_end_and_the_worst_violation(solutions) -> None:
    counts = {name: value for name, value in effort_table(solutions).rows}
    ends = {name: int(counts[name]) for name in get_args(Status)}
    assert ends == {"solved": 108, "infeasible": 1, "failed": 1, "screened": 2, "probed": 3}
    assert sum(ends.values()) == len(solutions)
    assert counts["worst scaled violation of a solved task"] == "3e-09"
    assert dict(effort_table([]).rows)["worst scaled violation of a solved task"] == "–"


def test_every_motion_is_checked_again_by_kind(anymal, trot, solved) -> None:
    other = solved(0.2, 0.8, trot.pattern)
    table = check_table(anymal.as_data(), [trot, other])
    rows = as_dict(table)
    kinds = violations(anymal.as_data(), trot.trajectory, trot.task, trot.pattern)
    assert list(rows) == list(kinds) and len(kinds) >= 15
    assert {row["within 1e-06"] for row in rows.values()} == {"yes"}
    worst = max(
        violations(anymal.as_data(), one.trajectory, one.task, one.pattern)["dynamics"] for one in (trot, other)
    )
    assert rows["dynamics"]["worst value"] == f"{worst:.1e}"


def test_a_violation_is_found_flagged_and_placed(anymal, trot, solved) -> None:
    """Whatever the row says of itself: one foot is moved by a millimetre in stance."""
    feet = trot.trajectory.feet.copy()
    feet[5, 1, 0] += 1e-3
    slipped = replace(solved(0.2, 0.8, trot.pattern), violation=0.0)
    broken = replace(trot, trajectory=replace(trot.trajectory, feet=feet), violation=0.0)
    table = check_table(anymal.as_data(), [slipped, broken])
    rows = as_dict(table)
    assert rows["slip in stance"]["within 1e-06"] == "NO"
    assert rows["slip in stance"]["worst value"] == "1.0e-03"
    assert (rows["slip in stance"]["v [m/s]"], rows["slip in stance"]["T [s]"]) == ("0.3", "0.8")
    assert rows["friction"]["within 1e-06"] == "yes"
    assert table.rows[table.marked][2] == "NO"
    nowhere = [row for row in rows.values() if row["worst value"] == "0.0e+00"]
    assert nowhere and {(row["v [m/s]"], row["T [s]"]) for row in nowhere} == {("–", "–")}
    assert check_table(anymal.as_data(), []).rows == ()


def test_motions_are_judged_between_their_knots_as_well(anymal, trot) -> None:
    found = between_knots(anymal.as_data(), trot.trajectory, trot.task, trot.pattern)
    rows = as_dict(between_knots_table(anymal.as_data(), [trot]))
    assert list(rows) == list(found)
    assert rows["dynamics"]["worst value"] == f"{found['dynamics']:.1e}"
    assert (rows["dynamics"]["v [m/s]"], rows["dynamics"]["T [s]"]) == ("0.3", "0.8")


def test_tasks_of_a_map_with_further_axes_are_told_in_full(sloped_labels, sloped) -> None:
    table = tie_table(sloped_labels, sloped.tasks.space)
    assert table.columns[:4] == ("v [m/s]", "T [s]", "slope [°]", "split")
    assert table.rows[0][:4] == ("0.1", "0.4", "-22", "grid")


def test_the_published_method_is_marked_and_missing_numbers_are_dashes(learning) -> None:
    table = learning_table(learning)
    assert table.rows[table.marked][0] == "svm"
    assert as_dict(table)["mlp"]["accuracy"] == "95 % / 94 %"
    learning = {**learning, "competitors": [dict(one) for one in learning["competitors"]]}
    learning["competitors"][0]["held_out"] = dict.fromkeys(learning["competitors"][0]["held_out"])
    assert as_dict(learning_table(learning))["mlp"]["accuracy"] == "95 % / –"


def test_provenance_names_code_machine_and_date(record) -> None:
    rows = dict(provenance_table(record).rows)
    assert rows["code"] == "gaitflow 0.1.0, commit 0123abc, with uncommitted changes"
    assert rows["packages"] == "casadi 3.8.2, numpy 2.4.6"
    assert rows["machine"] == "Example CPU, Linux x86_64, Python 3.11.2"
    assert rows["scenario digest"] == record["scenario_digest"]


def test_numbers() -> None:
    assert [number(x) for x in (None, math.nan, math.inf, 0.0123456, 12345.6)] == ["–", "–", "∞", "0.0123", "12,346"]
    assert [percent(x) for x in (None, math.inf, 0.00123, 1e-9, 0.0)] == ["–", "∞", "0.123 %", "< 0.001 %", "0 %"]
