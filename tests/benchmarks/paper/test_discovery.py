from __future__ import annotations

import json
from pathlib import Path

import pytest
from planted_child import PlantedChild
from tasks_at import at

from benchmarks.paper import discovery
from benchmarks.paper.discovery import by_task, compare, run, search_keys, summarise
from benchmarks.search.search import LOST
from gaitflow.config.scenario import Scenario


def row(method: str, cost: float | None, cpu: float, seed: int | None = None, **changes) -> dict:
    return {
        "speed": 1.0, "cycle_duration": 0.6, "method": method, "seed": seed, "cost": cost,
        "gait": "gallop" if cost else None, "pattern": "0011/0110" if cost else None,
        "violation": 1e-9 if cost else None, "status": "solved" if cost else "failed", "solver_status": "planted",
        "cpu_s": cpu, "whole_cpu_s": cpu + 1.0, "wall_s": cpu, "solves": 5, "counts": {}, "costs": {},
        "measured": "2026-01-01T00:00:00+00:00",
    } | changes  # fmt: skip


OURS = row("patterns", 100.0, 3.0)
RESTARTS = [
    row("bonmin", 125.0, 30.0, 0, gait="walking"),
    row("bonmin", None, 50.0, 1, status=LOST, solver_status="crashed: SIGSEGV"),
    row("bonmin", 100.005, 20.0, 2),
    row("bonmin", None, 5.0, 3),
    row("bonmin", 100.0 / 1.0001, 35.0, 4),
]


def test_one_task_counts_every_restart_with_its_time() -> None:
    found = compare(OURS, RESTARTS)
    assert found["bonmin"]["cost"] == 100.0 / 1.0001
    assert found["cost_worse_rel"] == pytest.approx(1e-4)
    assert found["bonmin"]["failed"] == 2
    assert found["bonmin"]["cpu_s"] == 140.0, "failed restarts took their time too"
    assert found["bonmin"]["cpu_s_per_restart"] == 28.0
    assert found["bonmin"]["agree"] == 1
    assert found["bonmin"]["gaits_found"] == 2
    assert found["cpu_ratio"] == 35.0, "against all of ours, building included"
    assert found["cpu_ratio_solver"] == pytest.approx(140 / 3)
    assert [restart["seed"] for restart in found["restarts"]] == [0, 1, 2, 3, 4]
    assert found["restarts"][1]["solver_status"] == "crashed: SIGSEGV"


def test_restarts_within_the_tolerance_agree() -> None:
    near = [row("bonmin", cost, 1.0, seed) for seed, cost in enumerate([100.0, 100.009, 100.011])]
    assert compare(OURS, near)["bonmin"]["agree"] == 2


def test_summary_takes_the_worst_cost_and_the_median_ratio() -> None:
    rows = [
        compare(OURS, [row("bonmin", 100.0, 400.0, 0), row("bonmin", 110.0, 400.0, 1)]),
        compare(OURS, [row("bonmin", 80.0, 40.0, 0), row("bonmin", None, 40.0, 1)]),
        compare(OURS, [row("bonmin", 200.0, 4.0, 0), row("bonmin", 200.0, 4.0, 1)]),
    ]
    summary = summarise(rows, 2)
    assert (summary["tasks"], summary["restarts"]) == (3, 2)
    assert summary["cost_worse_max_rel"] == pytest.approx(0.25)
    assert summary["cost_worse_min_rel"] == pytest.approx(-0.5)
    assert (summary["cpu_ratio_min"], summary["cpu_ratio_median"], summary["cpu_ratio_max"]) == (2.0, 20.0, 200.0)
    assert summary["cpu_ratio_per_restart_median"] == 10.0
    assert summary["bonmin_restarts_failed"] == 1
    assert summary["bonmin_restarts_agree"] == 4
    assert (summary["missed_by_patterns"], summary["missed_by_bonmin"]) == (0, 0)


def test_a_motion_that_patterns_missed_leaves_no_worst_cost_to_boast_of() -> None:
    good = compare(OURS, [row("bonmin", 100.0, 4.0, 0)])
    missed = compare(row("patterns", None, 3.0), [row("bonmin", 100.0, 4.0, 0)])
    summary = summarise([good, missed], 1)
    assert missed["cost_worse_rel"] is None
    assert summary["cost_worse_max_rel"] is None
    assert summary["missed_by_patterns"] == 1


def test_a_task_without_any_motion_or_that_bonmin_missed_is_not_compared() -> None:
    good = compare(OURS, [row("bonmin", 99.0, 4.0, 0)])
    nothing = compare(row("patterns", None, 0.0), [row("bonmin", None, 4.0, 0)])
    theirs = compare(OURS, [row("bonmin", None, 4.0, 0)])
    summary = summarise([good, nothing, theirs], 1)
    assert nothing["cpu_ratio_solver"] is None
    assert summary["cost_worse_max_rel"] == pytest.approx(1 / 99)
    assert (summary["missed_by_patterns"], summary["missed_by_bonmin"]) == (0, 1)
    assert summary["bonmin_restarts_failed"] == 2


def test_every_task_has_its_rows_whatever_their_order(scenario: Scenario) -> None:
    tasks = [at(1.0, 0.6), at(0.5, 0.6)]
    keys = search_keys(scenario, tasks, 2, 7)
    assert [(key["speed"], key["method"], key["seed"]) for key in keys] == [
        (1.0, "patterns", None), (1.0, "bonmin", 7), (1.0, "bonmin", 8),
        (0.5, "patterns", None), (0.5, "bonmin", 7), (0.5, "bonmin", 8),
    ]  # fmt: skip
    pairs = by_task(keys[::-1], [{"speed": task.speed, "cycle_duration": 0.6} for task in tasks])
    assert [ours["speed"] for ours, _ in pairs] == [1.0, 0.5]
    assert [{restart["seed"] for restart in restarts} for _, restarts in pairs] == [{7, 8}, {7, 8}]


class Planted(PlantedChild):
    """Stands for the child processes: answers from a list and counts."""

    calls = 0

    def call(self, limit_s: float, **request) -> dict:
        Planted.calls += 1
        name = self.setup["scenario"]["strategy"]["name"]
        cost = 100.0 if name == "patterns" else 110.0 + request["seed"]
        return {key: value for key, value in row(name, cost, 4.0).items() if key not in request | request["task"]}


def test_a_second_run_solves_nothing_and_more_restarts_only_the_new(scenario: Scenario, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(discovery, "Child", Planted)
    monkeypatch.setattr(Planted, "calls", 0)
    first = run(scenario, tasks=2, restarts=3, seed=5, runs=tmp_path)
    assert Planted.calls == 2 * (1 + 3)
    assert run(scenario, tasks=2, restarts=3, seed=5, runs=tmp_path)["rows"] == first["rows"]
    assert Planted.calls == 8
    assert run(scenario, tasks=2, restarts=4, seed=5, runs=tmp_path)["summary"]["restarts"] == 4
    assert Planted.calls == 10
    assert first["summary"]["cost_worse_max_rel"] == pytest.approx(-15 / 115)
    assert (first["bench"], first["scenario"]) == ("discovery", "quickstart")
    json.dumps(first, allow_nan=False)


def test_no_restarts_are_refused(scenario: Scenario, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="restarts = 0"):
        run(scenario, restarts=0, runs=tmp_path)


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_real_task_is_found_by_both(scenario: Scenario, tmp_path: Path, monkeypatch) -> None:
    done = run(scenario, tasks=1, restarts=1, runs=tmp_path)
    (found,) = done["rows"]
    assert found["patterns"]["status"] == found["bonmin"]["status"] == "solved"
    assert found["patterns"]["violation"] <= 1e-6
    assert found["cost_worse_rel"] <= 1e-4
    assert found["cpu_ratio"] > 0
    monkeypatch.setattr(discovery, "search", lambda *arguments: pytest.fail("was solved before"))
    assert run(scenario, tasks=1, restarts=1, runs=tmp_path)["rows"] == done["rows"]
