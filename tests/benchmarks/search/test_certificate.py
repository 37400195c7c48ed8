from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from tasks_at import at

from benchmarks.search import certificate
from benchmarks.search.certificate import compare, summarise
from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.dataset.labels import gait_costs, label_tasks
from gaitflow.search import solve_tasks
from gaitflow.store.units import plan_exhaustive
from gaitflow.tables.schema import scalar_columns
from gaitflow.tables.solutions import solutions_to_table

LABEL = {"speed": 1.0, "cycle_duration": 0.6, "gait": "gallop", "pattern": "0110/1100", "cost": 100.0}


def solves(**statuses: int) -> pd.DataFrame:
    """Rows of one task: a solved gallop at 100, a solved walk at 120, and so many others."""
    rows = [("0110/1100", "solved", "", 100.0), ("0111/1101", "solved", "", 120.0)]
    for number, (status, count) in enumerate(statuses.items()):
        reason = "costs at least 3, the incumbent 2" if status == "screened" else "told"
        rows += [(f"{number}/{index}", status, reason, float("nan")) for index in range(count)]
    frame = pd.DataFrame(rows, columns=["pattern", "status", "solver_status", "cost"])
    gait = frame["pattern"].where(frame["status"] == "solved", "01/10")
    frame = frame.assign(refined_cost=float("nan"), refined_knots=0)
    return frame.assign(gait=gait, speed=1.0, cycle_duration=0.6, split="grid", violation=1e-9, solves=1, cpu_s=0.5)


def test_the_label_s_own_optimum_certifies_it() -> None:
    row = compare(LABEL, solves(screened=5, infeasible=2), ("F", "H"))
    assert (row["gap_rel"], row["same_gait"], row["certified"]) == (0.0, True, True)
    assert (row["patterns"], row["dearer"], row["impossible"], row["solved"], row["infeasible"]) == (9, 5, 0, 2, 2)


def test_a_cheaper_motion_or_an_undecided_pattern_does_not() -> None:
    missed = compare(LABEL | {"gait": "walking", "pattern": "0111/1101", "cost": 120.0}, solves(), ("F", "H"))
    assert missed["gap_rel"] == pytest.approx(0.2)
    assert not missed["certified"] and not missed["same_gait"]
    assert not compare(LABEL, solves(failed=1), ("F", "H"))["certified"]
    summary = summarise([missed, compare(LABEL, solves(screened=6), ("F", "H"))])
    assert (summary["tasks"], summary["certified"], summary["same_gait"]) == (2, 1, 1)
    assert summary["gap_max_rel"] == pytest.approx(0.2)
    assert summary["ruled_out_share"] == pytest.approx(0.6)


def test_parts_together_are_the_whole_search(scenario: Scenario) -> None:
    task = at(0.9, 0.6)
    units = plan_exhaustive(scenario, {task: 1e9}, 3)
    assert len({unit.digest for unit in units}) == 3
    parts = [row.pattern for unit in units for row in solve_tasks(unit.scenario, unit.tasks, unit.seeds)]
    whole = [row.pattern for row in solve_tasks(scenario, [task])]
    assert sorted(parts) == sorted(whole)
    assert len(set(parts)) == len(parts)


@pytest.mark.slow
def test_a_guided_map_is_certified_and_found_again(scenario: Scenario, tmp_path: Path) -> None:
    guided = scenario.model_copy(update={"strategy": scenario.strategy.model_copy(update={"name": "guided"})})
    tasks = [task for task in tasks_of(guided) if task.split == "grid"]
    found = [row for task in tasks for row in solve_tasks(guided, [task])]
    table = solutions_to_table(found, guided.as_data())
    frame = table.select(scalar_columns(table.column_names)).to_pandas()
    labels = label_tasks(gait_costs(frame, guided.robot.leg_names), tasks, 1e-3, 3)
    done = certificate.run(guided, labels, tasks=2, runs=tmp_path)
    assert done["summary"]["tasks"] == 2 and done["summary"]["problem"] == guided.problem_digest
    assert [row["certified"] for row in done["rows"]] == [row["undecided"] == 0 for row in done["rows"]]
    assert abs(done["summary"]["gap_max_rel"]) < 1e-3
    parts = sorted((tmp_path / "bench").rglob("*.parquet"))
    before = [part.stat().st_mtime_ns for part in parts]
    assert len(parts) == 2 * certificate.PARTS
    assert certificate.run(guided, labels, tasks=2, runs=tmp_path)["rows"] == done["rows"]
    assert [part.stat().st_mtime_ns for part in parts] == before, "a stored unit was solved again"
