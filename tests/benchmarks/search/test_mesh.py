from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from planted_child import PlantedChild

from benchmarks.search import mesh
from benchmarks.search.mesh import EULER, Rule, judge, own_rule, reference_rule, rules, run, summarise
from gaitflow.config.scenario import Scenario

GALLOP, WALK = "0011/0110", "0111/1101"


def solve(speed: float, pattern: str, cost: float | None, cpu: float = 1.0) -> dict[str, Any]:
    return {
        "speed": speed, "cycle_duration": 0.6, "pattern": pattern, "cost": cost, "feasible": cost is not None,
        "iterations": 10, "cpu_s": cpu, "method": "interior_point",
    }  # fmt: skip


FINE = [solve(0.5, GALLOP, 100.0), solve(0.5, WALK, 90.0), solve(1.0, GALLOP, 50.0), solve(1.0, WALK, 200.0)]
EULERS = [solve(0.5, GALLOP, 95.0, 0.5), solve(0.5, WALK, 99.0, 2.0), solve(1.0, GALLOP, None), solve(1.0, WALK, 180.0)]


def test_a_label_is_wrong_where_its_gait_is_dearer_on_the_reference(scenario: Scenario) -> None:
    """At 0.5 m/s this rule takes the gallop for the cheapest, 11 % above the walk; at 1 m/s it lacks the gallop."""
    told = judge(scenario, EULERS, FINE, EULERS)
    assert told["wrong_labels"] == 2
    assert told["wrong_worst"] == pytest.approx(3.0)
    assert told["best_cost_error_median"] == pytest.approx((5 / 90 + 130 / 50) / 2)
    assert told["best_cost_error_worst"] == pytest.approx(2.6)
    assert (told["compared"], told["failed"], told["solves"]) == (2, 1, 4)
    assert told["cpu_ratio_to_euler10"] == told["cpu_ratio_total"] == 1.0


def test_a_rule_that_is_right_within_a_hundredth_has_no_wrong_label(scenario: Scenario) -> None:
    near = [solve(0.5, GALLOP, 100.0), solve(0.5, WALK, 100.1), solve(1.0, GALLOP, 50.4), solve(1.0, WALK, 60.0)]
    close = [*FINE[:1], solve(0.5, WALK, 99.1), *FINE[2:]]
    told = judge(scenario, near, close, EULERS)
    assert (told["wrong_labels"], told["wrong_worst"]) == (0, 0.0), "0.9 % is no wrong label"
    assert told["best_cost_error_worst"] == pytest.approx(0.9 / 99.1)
    # Both found a motion in three cases: 1 / 0.5, 1 / 2 and 1 / 1 times the CPU time.
    assert told["cpu_ratio_to_euler10"] == pytest.approx(1.0)
    assert told["cpu_ratio_total"] == pytest.approx(3 / 3.5)


def test_a_task_without_any_motion_is_not_compared(scenario: Scenario) -> None:
    nothing = [row | {"cost": None, "feasible": False} for row in FINE]
    told = judge(scenario, nothing, FINE, EULERS)
    assert (told["compared"], told["failed"], told["wrong_labels"]) == (0, 4, 0)
    assert told["best_cost_error_median"] is told["cpu_ratio_to_euler10"] is told["cpu_s_median"] is None
    assert judge(scenario, FINE, nothing, EULERS)["failed"] == 0


def test_rules_are_eulers_and_every_other_integrators(scenario: Scenario) -> None:
    every = rules(scenario)
    assert every[0] == EULER and len(set(every)) == len(every)
    assert {rule.integrator for rule in every} == {"euler", "rk4", "midpoint", "hermite_simpson", "momentum"}
    assert reference_rule(scenario) in every and own_rule(scenario) in every
    for rule in every:
        sized = rule.on(scenario, 7)
        assert Scenario.from_data(sized.as_data(), "test") == sized
        assert (sized.transcription.integrator, sized.transcription.knots_per_phase) == (rule.integrator, 7)
        assert sized.transcription.phases == scenario.transcription.phases
    euler = EULER.on(scenario, 10)
    assert own_rule(euler) == Rule("momentum", "linear", 1.0)


def test_the_summary_is_of_the_scenarios_own_mesh(scenario: Scenario) -> None:
    own = own_rule(scenario)
    told = judge(scenario, EULERS, FINE, EULERS)
    row = {"integrator": own.integrator, "forces": own.forces, "grading": own.grading, "knots": 3} | told
    summary = summarise(scenario, [row | {"knots": 4, "wrong_labels": 9}, row])
    assert summary["wrong_labels"] == 2
    assert {"best_cost_error_median", "wrong_labels", "cpu_ratio_to_euler10"} <= set(summary)
    assert summarise(scenario, [])["wrong_labels"] is None


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_small_real_table(scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh, "REFERENCE_KNOTS", 8)
    chosen = (EULER, own_rule(scenario))
    done = run(scenario, tasks=1, runs=tmp_path, knots=(3, 6), chosen_rules=chosen)
    assert [(row["integrator"], row["knots"]) for row in done["rows"]] == [
        (rule.integrator, knots) for rule in chosen for knots in (3, 6)
    ]
    coarse, fine = done["rows"][2:]
    assert fine["best_cost_error_median"] < coarse["best_cost_error_median"]
    assert all(row["compared"] == 1 and row["cpu_ratio_to_euler10"] > 0 for row in done["rows"])
    assert done["summary"]["best_cost_error_median"] == coarse["best_cost_error_median"]
    monkeypatch.setattr(mesh.child, "Child", PlantedChild)
    assert run(scenario, tasks=1, runs=tmp_path, knots=(3, 6), chosen_rules=chosen)["rows"] == done["rows"]
    json.dumps(done, allow_nan=False)
