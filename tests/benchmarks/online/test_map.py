from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.online.map import PAUSE_S, active_seconds, run
from benchmarks.search.tasks import task_of
from gaitflow.config.scenario import Scenario
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.dataset.read import Solutions
from gaitflow.search import Solution, solve_tasks
from gaitflow.store.journal import Entry
from gaitflow.tables.solutions import solutions_to_table

TROT = "0011/1100/1100/0011"
SPEEDS = (0.5, 0.7, 9.0)


def stored(end: float, wall: float) -> Entry:
    return Entry("stored", "unit", end, "solver", cpu_s=wall, wall_s=wall, kept=True)


def test_units_side_by_side_count_once() -> None:
    assert active_seconds([stored(100.0, 60.0), stored(90.0, 50.0)]) == pytest.approx(60.0)


def test_a_pause_between_sessions_is_left_out() -> None:
    first, later = stored(60.0, 60.0), stored(60.0 + PAUSE_S + 1000.0, 30.0)
    assert active_seconds([first, later]) == pytest.approx(90.0)


def test_the_moments_between_units_belong_to_the_run() -> None:
    assert active_seconds([stored(60.0, 60.0), stored(130.0, 65.0)]) == pytest.approx(130.0)


def test_no_journal_is_no_time() -> None:
    assert active_seconds([Entry("start", "unit", 5.0, "solver")]) == 0.0


@pytest.fixture(scope="module")
def trots(spatial: Scenario) -> list[Solution]:
    """A trot at each task, the fastest of which no leg can follow, and a pattern that was ruled out."""
    changes = {"name": "fixed_gait", "pattern": TROT, "restarts": 1}
    only = spatial.model_copy(update={"strategy": spatial.strategy.model_copy(update=changes)})
    found = solve_tasks(only, [task_of(spatial, {"speed": v, "cycle_duration": 0.8}) for v in SPEEDS])
    assert [solution.status for solution in found[:2]] == ["solved", "solved"]
    out = {"pattern": "1111/1111/1111/1111", "gait": "1/1/1/1", "status": "screened", "solves": 0, "cpu_s": 0.0}
    return [*found, replace(found[0], trajectory=None, multipliers=None, cost=float("nan"), **out)]


def measured(scenario: Scenario, solutions: list[Solution]) -> dict:
    data = scenario.as_data()
    stored_rows = Solutions(solutions_to_table(solutions, data), {"scenario": data})
    tasks = [task_of(scenario, {"speed": v, "cycle_duration": 0.8}) for v in SPEEDS]
    labels = label_tasks(gait_costs(stored_rows.frame(), scenario.robot.leg_names), tasks, 1e-3, 3)
    return run(scenario, stored_rows, labels, [stored(60.0, 30.0), stored(90.0, 20.0)])


def test_in_space_every_label_is_judged_anew(spatial: Scenario, trots: list[Solution]) -> None:
    done = measured(spatial, trots)
    summary = done["summary"]
    assert (summary["tasks"], summary["labelled"], summary["infeasible_tasks"]) == (3, 2, 1)
    kinds = summary["worst_violation_by_kind"]
    assert {"dynamics", "kinematic box", "friction", "periodicity", "force in swing", "slip in stance"} <= set(kinds)
    assert 0 < max(kinds.values()) == summary["worst_label_violation"] <= 1e-6
    assert 1e-4 < summary["worst_gap_between_knots"] == max(row.get("gap_between_knots", 0) for row in done["rows"])
    json.dumps(done, allow_nan=False)


def test_costs_on_a_finer_mesh_say_how_many_labels_stand(spatial: Scenario, trots: list[Solution]) -> None:
    assert "resolved" not in measured(spatial, trots)["summary"]
    finer = [replace(one, refined_cost=0.98 * one.cost, refined_knots=6) for one in trots[:2]]
    done = measured(spatial, [*finer, *trots[2:]])
    assert done["summary"]["cost_error_max"] == pytest.approx(0.02 / 0.98)
    assert done["summary"]["resolved"] == 2, "each has no other gait"
    assert done["rows"][0]["resolved"] is True and done["rows"][0]["cost_error"] == pytest.approx(0.02 / 0.98)


def test_what_a_label_took(spatial: Scenario, trots: list[Solution]) -> None:
    done = measured(spatial, trots)
    first, _, last = done["rows"]
    assert (first["tried"], first["screened"], first["solves"]) == (1, 1, trots[0].solves)
    assert first["solver_cpu_s"] == pytest.approx(trots[0].cpu_s)
    assert (last["tried"], last["screened"]) == (int(trots[2].solves > 0), int(trots[2].status == "screened"))
    assert done["summary"]["cpu_s_per_labelled_task"] == pytest.approx(50.0 / 2)
    assert done["summary"]["solves_per_task_median"] == np.median([row.solves for row in trots[:3]])


def test_a_motion_that_breaks_a_law_is_found_whatever_its_row_says(spatial: Scenario, trots: list[Solution]) -> None:
    motion = trots[0].trajectory
    assert motion is not None
    forces = motion.forces.copy()
    forces[0, 0, 2] += 3.0  # a leg in swing [N]
    spoilt = [replace(trots[0], trajectory=replace(motion, forces=forces)), *trots[1:]]
    kinds = measured(spatial, spoilt)["summary"]["worst_violation_by_kind"]
    assert kinds["force in swing"] == pytest.approx(3.0 / (spatial.robot.mass * 9.81))
    assert kinds["dynamics"] > 1e-4
    assert kinds["kinematic box"] <= 1e-6
