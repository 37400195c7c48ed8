"""Gait costs, margins, ties and the labels that follow their neighbourhood."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.config.tasks import Task
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.dataset.labels import COSTS, LABELS, TASK, gait_costs, label_tasks, mark_failed

LEGS = ("F", "H")
GALLOP, WALK, BOUND = (gait_of(Pattern.from_text(text)).text for text in ("0110/1100", "0111/1101", "0001/0100"))
NAMES = {GALLOP: "gallop", WALK: "walking", BOUND: "bounding"}


def solve(task: Task, gait: str, cost: float, **other: Any) -> dict[str, Any]:
    row = {"speed": task.speed, "cycle_duration": task.cycle_duration, "split": task.split, "pattern": gait}
    return row | {"gait": gait, "status": "solved", "cost": cost, "violation": 1e-9} | other


def labels_of(table: dict[Task, dict[str, float]], tolerance: float = 1e-3) -> pd.DataFrame:
    """Labels of the tasks in `table`, which holds the cost of each gait."""
    rows = [solve(task, gait, cost) for task, costs in table.items() for gait, cost in costs.items()]
    rows += [solve(task, WALK, np.nan, status="infeasible", violation=np.nan) for task in table]
    return label_tasks(gait_costs(pd.DataFrame(rows), LEGS), list(table), tolerance)


def grid(rows: Sequence[str], costs: dict[str, dict[str, float]]) -> dict[Task, dict[str, float]]:
    """A map drawn with a letter a task, speeds to the right and durations downwards."""
    return {Task(float(v), float(t + 1)): costs[letter] for t, row in enumerate(rows) for v, letter in enumerate(row)}


def test_a_gait_costs_what_its_cheapest_pattern_costs() -> None:
    task = Task(0.5, 1.0)
    solutions = pd.DataFrame(
        [
            solve(task, WALK, 3.0, pattern="0111/1101"),
            solve(task, GALLOP, 2.0, pattern="0110/1100"),
            solve(task, WALK, 1.5, pattern="1110/1011"),
        ]
    )
    costs = gait_costs(solutions, LEGS)
    assert list(costs.columns) == COSTS
    assert costs[["gait", "gait_key", "pattern", "cost"]].to_numpy().tolist() == [
        ["walking", WALK, "1110/1011", 1.5],
        ["gallop", GALLOP, "0110/1100", 2.0],
    ]


@pytest.mark.parametrize(
    "reason",
    [{"status": "failed"}, {"status": "infeasible"}, {"violation": 2e-6}, {"violation": np.nan}, {"cost": np.nan}],
)
def test_a_solve_that_does_not_hold_is_no_cost(reason: dict[str, Any]) -> None:
    task = Task(0.5, 1.0)
    solutions = pd.DataFrame([solve(task, WALK, 1.0) | reason, solve(task, GALLOP, 2.0)])
    assert gait_costs(solutions, LEGS)["gait"].tolist() == ["gallop"]


def test_grid_and_held_out_costs_of_one_task_stay_apart() -> None:
    solutions = pd.DataFrame([solve(Task(0.5, 1.0, split), WALK, 1.0) for split in ("grid", "held_out")])
    assert gait_costs(solutions, LEGS)["split"].tolist() == ["grid", "held_out"]


def test_margin_runner_up_and_ties() -> None:
    task = Task(0.5, 1.0)
    row = labels_of({task: {WALK: 2.0, GALLOP: 2.001, BOUND: 3.0}}, tolerance=1e-3).iloc[0]
    assert list(row.index) == LABELS
    assert (row["gait"], row["gait_key"], row["pattern"], row["cost"]) == ("walking", WALK, WALK, 2.0)
    assert row["runner_up"] == "gallop"
    assert row["margin"] == pytest.approx(0.0005)
    assert row["ties"] == ["walking", "gallop"]
    assert row["label"] == "walking"


def test_a_single_feasible_gait_has_an_infinite_margin() -> None:
    row = labels_of({Task(0.5, 1.0): {WALK: 2.0}}).iloc[0]
    assert row["margin"] == np.inf
    assert (row["runner_up"], row["ties"]) == ("", ["walking"])


def test_a_task_without_a_feasible_gait_is_infeasible_and_keeps_its_place() -> None:
    tasks = {Task(0.0, 1.0): {WALK: 1.0}, Task(1.0, 1.0): {}, Task(2.0, 1.0): {GALLOP: 1.0}}
    labels = labels_of(tasks)
    assert labels["status"].tolist() == ["solved", "infeasible", "solved"]
    assert labels[["gait", "gait_key", "pattern", "runner_up", "label"]].iloc[1].tolist() == [""] * 5
    assert labels["ties"].iloc[1] == []
    assert labels[["cost", "margin"]].iloc[1].isna().all()


def test_a_map_where_nothing_is_feasible_has_labels_too() -> None:
    labels = labels_of({Task(0.0, 1.0): {}, Task(1.0, 1.0): {}})
    assert labels["status"].tolist() == ["infeasible", "infeasible"]


COSTS_OF = {
    "W": {WALK: 1.0, GALLOP: 2.0},
    "G": {WALK: 2.0, GALLOP: 1.0},
    "w": {WALK: 1.0, GALLOP: 1.0005, BOUND: 5.0},  # ties, walking a hair cheaper
    "g": {WALK: 1.0005, GALLOP: 1.0, BOUND: 5.0},
    "b": {BOUND: 1.0, GALLOP: 1.0005},
    ".": {},
}


def drawn(labels: pd.DataFrame, width: int) -> list[str]:
    letters = "".join(label[0] if label else "." for label in labels[labels["split"] == "grid"]["label"])
    return [letters[i : i + width] for i in range(0, len(letters), width)]


@pytest.mark.parametrize(
    ("costs", "expected"),
    [
        (["WWW", "WgW", "WWW"], ["www", "www", "www"]),  # noise inside a region goes
        (["WWW", "WGW", "WWW"], ["www", "wgw", "www"]),  # a gait that is really cheaper stays
        (["WWWGGG", "WgwgwG", "WWWGGG"], ["wwwggg", "wwwggg", "wwwggg"]),  # it spreads from task to task
        (["WWW", "WbW", "WWW"], ["www", "wbw", "www"]),  # never to a gait outside the ties
        (["w.g"], ["w.g"]),  # no neighbour, no change
        (["wg"], ["gg"]),  # and one that ties alone decides
    ],
)
def test_within_ties_a_label_follows_its_neighbourhood(costs: list[str], expected: list[str]) -> None:
    labels = labels_of(grid(costs, COSTS_OF))
    assert drawn(labels, len(costs[0])) == expected


def test_labels_do_not_depend_on_the_order_of_rows() -> None:
    table = grid(["WwgG", "wgwg", "gwgw", "WgwG"], COSTS_OF)
    forwards = labels_of(table).sort_values(TASK).reset_index(drop=True)
    backwards = labels_of(dict(reversed(table.items()))).sort_values(TASK).reset_index(drop=True)
    pd.testing.assert_frame_equal(forwards, backwards)


@given(st.lists(st.text("WGwgb.", min_size=5, max_size=5), min_size=1, max_size=5))
def test_every_label_ties_with_the_cheapest_gait_and_no_neighbourhood_outvotes_it(rows: list[str]) -> None:
    labels = labels_of(grid(rows, COSTS_OF))
    solved = labels[labels["status"] == "solved"]
    assert all(label in ties for label, ties in zip(solved["label"], solved["ties"], strict=True))
    place = {(row.speed, row.cycle_duration): row for row in labels.itertuples()}
    for (v, t), row in place.items():
        around = [place.get((v + dv, t + dt)) for dv in (-1, 0, 1) for dt in (-1, 0, 1) if (dv, dt) != (0, 0)]
        votes = [other.label for other in around if other is not None]
        assert all(votes.count(gait) <= votes.count(row.label) for gait in row.ties)


def test_held_out_tasks_follow_the_grid_and_never_lead_it() -> None:
    table = grid(["WWW", "WgW", "WWW"], COSTS_OF)
    alone = labels_of(table)
    held = {
        Task(0.5, 1.5, "held_out"): COSTS_OF["g"],
        Task(1.0, 2.0, "held_out"): COSTS_OF["G"],
        Task(1.1, 2.1, "held_out"): COSTS_OF["G"],
        Task(0.9, 2.1, "held_out"): COSTS_OF["g"],
    }
    together = labels_of(table | held)
    pd.testing.assert_frame_equal(together.iloc[: len(alone)], alone)
    assert together["label"].iloc[len(alone) :].tolist() == ["walking", "gallop", "gallop", "walking"]


IMPOSSIBLE = ("screened", "stance travel and swing speed do not fit into the cycle")
DEARER = ("screened", "costs at least 9, the incumbent 8")
NO_MOTION = ("infeasible", "Infeasible_Problem_Detected")
LIMIT = ("failed", "Maximum_Iterations_Exceeded")


@pytest.mark.parametrize(
    ("tried", "status"),
    [
        ([NO_MOTION, NO_MOTION], "infeasible"),
        ([NO_MOTION, IMPOSSIBLE], "infeasible"),
        ([IMPOSSIBLE, ("screened", "no leg ever stands"), ("screened", "a leg never leaves the ground")], "infeasible"),
        ([LIMIT, LIMIT], "failed"),
        ([LIMIT, NO_MOTION], "failed"),
        ([LIMIT, IMPOSSIBLE], "failed"),
        ([NO_MOTION, ("probed", "costs 3 on the coarse mesh, too much to be promising")], "failed"),
        ([NO_MOTION, ("probed", "no motion found on the coarse mesh: Infeasible_Problem_Detected")], "failed"),
        ([NO_MOTION, DEARER], "failed"),
        ([], "failed"),
    ],
)
def test_a_task_is_infeasible_only_when_every_pattern_got_that_verdict(
    tried: list[tuple[str, str]], status: str
) -> None:
    one, solved = Task(0.1, 0.4), Task(0.3, 0.4)
    rows = [solve(one, WALK, np.nan, status=end, solver_status=said, violation=np.nan) for end, said in tried]
    rows += [solve(solved, WALK, 2.0, solver_status="Solve_Succeeded")]
    rows += [solve(solved, GALLOP, np.nan, status=end, solver_status=said) for end, said in tried]
    solutions = pd.DataFrame(rows)
    labels = label_tasks(gait_costs(solutions, LEGS), [one, solved], 1e-3)
    assert mark_failed(labels, solutions)["status"].tolist() == [status, "solved"]
