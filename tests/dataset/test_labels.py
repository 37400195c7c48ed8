"""Gait costs, margins, ties and the labels that follow their neighbourhood."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.names import gait_name
from gaitflow.core.task import Split, Task
from gaitflow.dataset.labels import COSTS, LABELS, gait_costs, label_tasks, mark_failed
from gaitflow.dataset.labels_file import read_labels
from gaitflow.dataset.legacy import modern_names

LEGS = ("F", "H")
GALLOP, WALK, BOUND = (gait_of(Pattern.from_text(text)).text for text in ("0110/1100", "0111/1101", "0001/0100"))
NAMES = {GALLOP: "gallop", WALK: "walking", BOUND: "bounding"}


KNOTS = 10
AXES = ["speed", "cycle_duration"]
TASK = [*AXES, "split"]


def at(speed: float, cycle_duration: float, split: Split = "grid", **others: float) -> Task:
    return Task.of({"speed": speed, "cycle_duration": cycle_duration, **others}, split)


def solve(task: Task, gait: str, cost: float, axes: Sequence[str] = AXES, **other: Any) -> dict[str, Any]:
    row = {axis: task[axis] for axis in axes} | {"split": task.split, "pattern": gait}
    known = {"gait": gait, "status": "solved", "cost": cost, "violation": 1e-9}
    return row | known | {"refined_cost": np.nan, "refined_knots": 0} | other


def labels_of(table: dict[Task, dict[str, float]], tolerance: float = 1e-3) -> pd.DataFrame:
    """Labels of the tasks in `table`, which holds the cost of each gait."""
    rows = [solve(task, gait, cost) for task, costs in table.items() for gait, cost in costs.items()]
    rows += [solve(task, WALK, np.nan, status="infeasible", violation=np.nan) for task in table]
    return label_tasks(gait_costs(pd.DataFrame(rows), LEGS), list(table), tolerance, KNOTS)


def grid(rows: Sequence[str], costs: dict[str, dict[str, float]]) -> dict[Task, dict[str, float]]:
    """A map drawn with a letter a task, speeds to the right and durations downwards."""
    return {at(float(v), float(t + 1)): costs[letter] for t, row in enumerate(rows) for v, letter in enumerate(row)}


def test_a_gait_costs_what_its_cheapest_pattern_costs() -> None:
    task = at(0.5, 1.0)
    solutions = pd.DataFrame(
        [
            solve(task, WALK, 3.0, pattern="0111/1101"),
            solve(task, GALLOP, 2.0, pattern="0110/1100"),
            solve(task, WALK, 1.5, pattern="1110/1011"),
        ]
    )
    costs = gait_costs(solutions, LEGS)
    assert list(costs.columns) == [*TASK, *COSTS]
    assert costs[["gait", "gait_key", "pattern", "cost"]].to_numpy().tolist() == [
        ["walking", WALK, "1110/1011", 1.5],
        ["gallop", GALLOP, "0110/1100", 2.0],
    ]


@pytest.mark.parametrize(
    "reason",
    [{"status": "failed"}, {"status": "infeasible"}, {"violation": 2e-6}, {"violation": np.nan}, {"cost": np.nan}],
)
def test_a_solve_that_does_not_hold_is_no_cost(reason: dict[str, Any]) -> None:
    task = at(0.5, 1.0)
    solutions = pd.DataFrame([solve(task, WALK, 1.0) | reason, solve(task, GALLOP, 2.0)])
    assert gait_costs(solutions, LEGS)["gait"].tolist() == ["gallop"]


def test_grid_and_held_out_costs_of_one_task_stay_apart() -> None:
    solutions = pd.DataFrame([solve(at(0.5, 1.0, split), WALK, 1.0) for split in ("grid", "held_out")])
    assert gait_costs(solutions, LEGS)["split"].tolist() == ["grid", "held_out"]


def test_margin_runner_up_and_ties() -> None:
    task = at(0.5, 1.0)
    row = labels_of({task: {WALK: 2.0, GALLOP: 2.001, BOUND: 3.0}}, tolerance=1e-3).iloc[0]
    assert list(row.index) == [*TASK, *LABELS]
    assert (row["gait"], row["gait_key"], row["pattern"], row["cost"]) == ("walking", WALK, WALK, 2.0)
    assert row["runner_up"] == "gallop"
    assert row["margin"] == pytest.approx(0.0005)
    assert row["ties"] == ["walking", "gallop"]
    assert row["label"] == "walking"


MESHES = [
    # cost and refined cost of walking and gallop, knots of the finer mesh; winner, margin, error, resolved
    ((2.0, 1.9), (2.1, 2.09), 20, "walking", 0.1, 0.1 / 1.9, True),
    ((2.0, 1.9), (2.05, 1.8), 20, "gallop", 0.1 / 1.8, 0.25 / 1.8, False),
    ((2.0, 1.9), (2.05, 1.8), 40, "gallop", 0.1 / 1.8, 0.25 / 1.8, True),  # a third of the error is left
    ((2.0, 1.9), (2.05, 1.9001), 20, "walking", 0.0001 / 1.9, 0.1499 / 1.9001, True),  # a tie
    ((2.0, 1.9), (2.001, np.nan), 20, "walking", 0.0005, np.nan, True),  # a tie with a gait that was not asked any more
    ((2.0, np.nan), (2.001, np.nan), 0, "walking", 0.0005, np.nan, False),
    ((2.0, 1.9), (2.2, np.nan), 20, "walking", 0.1, np.nan, False),  # misjudged like walking: 2.2 counts as 2.09
    ((2.0, np.nan), (2.2, np.nan), 0, "walking", 0.1, np.nan, False),
]


@pytest.mark.parametrize(("walk", "gallop", "knots", "winner", "margin", "error", "resolved"), MESHES)
def test_costs_on_a_finer_mesh_decide(
    walk: tuple[float, float],
    gallop: tuple[float, float],
    knots: int,
    winner: str,
    margin: float,
    error: float,
    resolved: bool,
) -> None:
    task = at(0.5, 1.0)
    rows = [
        solve(task, gait, cost, refined_cost=finer, refined_knots=knots if np.isfinite(finer) else 0)
        for gait, (cost, finer) in ((WALK, walk), (GALLOP, gallop))
    ]
    costs = gait_costs(pd.DataFrame(rows), LEGS)
    row = label_tasks(costs, [task], 1e-3, KNOTS).iloc[0]
    assert (row["gait"], row["label"], row["resolved"]) == (winner, winner, resolved)
    assert row["margin"] == pytest.approx(margin) and row["cost_error"] == pytest.approx(error, nan_ok=True)
    assert row["cost"] == {"walking": walk, "gallop": gallop}[winner][0]
    assert costs["excess"].tolist() == [0.0, row["margin"]]


def test_a_gait_is_represented_by_its_pattern_of_least_refined_cost() -> None:
    task = at(0.5, 1.0)
    rows = [
        solve(task, WALK, 2.0, pattern="0111/1101", refined_cost=1.95, refined_knots=20),
        solve(task, WALK, 2.1, pattern="1110/1011", refined_cost=1.9, refined_knots=20),
    ]
    costs = gait_costs(pd.DataFrame(rows), LEGS)
    assert costs[["pattern", "cost", "refined_cost"]].to_numpy().tolist() == [["1110/1011", 2.1, 1.9]]


def test_what_is_known_of_a_gait_goes_before_what_is_assumed() -> None:
    task = at(0.5, 1.0)
    rows = [
        solve(task, GALLOP, 2.0, refined_cost=1.8, refined_knots=20),
        solve(task, WALK, 3.0, pattern="0111/1101", refined_cost=2.99, refined_knots=20),
        solve(task, WALK, 3.01, pattern="1110/1011"),  # 2.71 there, if it gained as much as gallop does
        solve(task, BOUND, 3.01),
    ]
    costs = gait_costs(pd.DataFrame(rows), LEGS)
    assert costs["gait"].tolist() == ["gallop", "walking", "bounding"]
    assert costs["pattern"].tolist()[1] == "0111/1101" and costs["excess"].is_monotonic_increasing
    row = label_tasks(costs, [task], 1e-3, KNOTS).iloc[0]
    assert (row["runner_up"], row["resolved"]) == ("walking", True)
    assert row["margin"] == pytest.approx(1.19 / 1.8)


def test_mirror_images_that_a_task_tells_apart_have_names_of_their_own() -> None:
    left, right = "0011/1101/1110/1101", "1101/0011/1101/1110"
    axes = [*AXES, "yaw_rate"]
    legs = ("LF", "RF", "LH", "RH")
    straight, turning = at(0.5, 1.0), at(0.5, 1.0, yaw_rate=0.4)
    rows = [solve(straight, left, 1.0, axes), solve(turning, left, 1.0, axes), solve(turning, right, 2.0, axes)]
    costs = gait_costs(pd.DataFrame(rows), legs)
    names = costs["gait"].tolist()
    assert names[0] == names[1] != names[2] and names[2].endswith(right)
    labels = label_tasks(costs, [straight, turning], 1e-3, KNOTS)
    assert labels["yaw_rate"].tolist() == [0.0, 0.4] and labels["runner_up"].tolist() == ["", names[2]]


def test_a_single_feasible_gait_has_an_infinite_margin() -> None:
    row = labels_of({at(0.5, 1.0): {WALK: 2.0}}).iloc[0]
    assert row["margin"] == np.inf and row["resolved"]
    assert (row["runner_up"], row["ties"]) == ("", ["walking"])


def test_a_task_without_a_feasible_gait_is_infeasible_and_keeps_its_place() -> None:
    tasks = {at(0.0, 1.0): {WALK: 1.0}, at(1.0, 1.0): {}, at(2.0, 1.0): {GALLOP: 1.0}}
    labels = labels_of(tasks)
    assert labels["status"].tolist() == ["solved", "infeasible", "solved"]
    assert labels[["gait", "gait_key", "pattern", "runner_up", "label"]].iloc[1].tolist() == [""] * 5
    assert labels["ties"].iloc[1] == []
    assert labels[["cost", "margin", "cost_error"]].iloc[1].isna().all() and not labels["resolved"].iloc[1]


def test_a_map_where_nothing_is_feasible_has_labels_too() -> None:
    labels = labels_of({at(0.0, 1.0): {}, at(1.0, 1.0): {}})
    assert labels["status"].tolist() == ["infeasible", "infeasible"]


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
    one, solved = at(0.1, 0.4), at(0.3, 0.4)
    rows = [solve(one, WALK, np.nan, status=end, solver_status=said, violation=np.nan) for end, said in tried]
    rows += [solve(solved, WALK, 2.0, solver_status="Solve_Succeeded")]
    rows += [solve(solved, GALLOP, np.nan, status=end, solver_status=said) for end, said in tried]
    solutions = pd.DataFrame(rows)
    labels = label_tasks(gait_costs(solutions, LEGS), [one, solved], 1e-3, KNOTS)
    assert mark_failed(labels, solutions)["status"].tolist() == [status, "solved"]


def test_names_of_published_labels_are_read_as_those_of_today() -> None:
    folder = Path(__file__).parents[2] / "datasets/anymal-energy/1.0.0"
    for file in ("labels.parquet", "gait_costs.parquet"):
        table = pq.read_table(folder / file)
        stored, today = table.to_pandas(), modern_names(table).to_pandas()
        keys = {key: gait_name(Pattern.from_text(key), ("LF", "RF", "LH", "RH")) for key in stored["gait_key"] if key}
        assert (today["gait"] == stored["gait_key"].map(keys).fillna("")).all()
        assert (today["gait"] != stored["gait"]).any()
    assert all(row["gait"] in row["ties"] for row in read_labels(folder).to_pylist())
