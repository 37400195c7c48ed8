from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tasks_at import at
from tiny_map import Solved, linear_classifier

from benchmarks.paper import minlp
from benchmarks.paper.fixed_gait import METHODS, scenario_of
from benchmarks.paper.table2 import run
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.names import gait_name
from gaitflow.problem import transcribe
from gaitflow.publishing import Parts, publish
from gaitflow.runtime.atlas import Atlas
from gaitflow.search.starts import nominal
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start


def guided(scenario: Scenario, **strategy: Any) -> Scenario:
    changes = {"name": "guided"} | strategy
    return scenario.model_copy(update={"strategy": scenario.strategy.model_copy(update=changes)})


def test_the_scenarios_own_search_is_the_reference(pristine: Path, tmp_path: Path, planted: Any) -> None:
    done = run(guided(scenario_of(pristine)), pristine, tasks=2, seed=1, runs=tmp_path)
    assert planted.calls == 2 * (1 + len(METHODS))
    assert list(done["summary"]) == [*METHODS, "guided"]
    assert done["summary"]["guided"]["consistent"] is None
    assert (done["summary"]["bigm_random"]["successful"], done["summary"]["bigm_random"]["runs"]) == (0, 2)
    for method in METHODS[1:]:
        told = done["summary"][method]
        assert (told["successful"], told["consistent"], told["runs"]) == (2, 2, 2), method
    again = run(guided(scenario_of(pristine)), pristine, tasks=3, seed=1, runs=tmp_path)
    assert planted.calls == 3 * (1 + len(METHODS)), "only the third task is new"
    assert again["summary"]["guided"]["runs"] == 3
    json.dumps(done, allow_nan=False)


def test_the_long_runs_of_bonmin_are_taken_over_and_not_repeated(pristine: Path, tmp_path: Path, planted: Any) -> None:
    scenario = scenario_of(pristine)
    long_runs = minlp.run(scenario, tasks=2, runs=tmp_path)
    before = planted.calls
    done = run(scenario, pristine, long_runs, tasks=1, runs=tmp_path)
    assert planted.calls == before + 1 + len(METHODS)
    assert list(done["summary"]) == ["minlp", *METHODS, "patterns"]
    told = done["summary"]["minlp"]
    assert (told["runs"], told["successful"], told["consistent"], told["time_mean_s"]) == (2, 0, 0, 9.0)
    assert done["summary"]["patterns"]["runs"] == 1, "the searches beside the long runs are not the table's"
    assert [row["budget_s"] for row in done["rows"] if row["method"] == "minlp"] == [minlp.BUDGET_S] * 2


def test_long_runs_of_another_problem_are_refused(pristine: Path, tmp_path: Path, planted: Any) -> None:
    scenario = scenario_of(pristine)
    long_runs = minlp.run(scenario, runs=tmp_path)
    long_runs["rows"][0]["problem"] = "0" * 64
    with pytest.raises(ValueError, match="gaitflow bench minlp --scenario quickstart` again"):
        run(scenario, pristine, long_runs, tasks=1, runs=tmp_path)


@pytest.fixture(scope="module")
def quadruped(spatial: Scenario, parts: Parts, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A published map in space: a walk below 0.5 m/s, a trot above."""
    hurried = spatial.strategy.model_copy(update={"solve_time_limit": 1.0})  # the big-M form may need it all
    problem = transcribe(spatial.model_copy(update={"strategy": hurried}))
    solver = FixedGaitSolver(problem, 20.0)
    starts = []
    walk, trot = "0111/1101/1110/1011", "0011/1100/1100/0011"
    for text, speed, cycle in ((walk, 0.3, 0.8), (trot, 0.6, 0.7)):
        glide = Start("nominal", nominal(spatial.robot, problem.layout, at(speed, cycle)))
        done = solver.solve(Pattern.from_text(text), at(speed, cycle), glide)
        assert done.feasible
        name = gait_name(gait_of(Pattern.from_text(text), spatial.symmetry(at(speed, cycle))), spatial.robot.leg_names)
        starts.append(Solved(name, text, done.w, done.multipliers.bounds, done.multipliers.rows))
    feasible = np.ones([each.count for each in spatial.tasks.ranges.values()], dtype=bool)
    classifier = linear_classifier([-5.0, 5.0], [2.5, -2.5])
    changed = {"problem": problem, "starts": starts, "classes": [start.gait for start in starts], "feasible": feasible}
    changed["atlas"] = Atlas.empty(("speed", "cycle_duration"))
    return publish(
        tmp_path_factory.mktemp("models"), replace(parts, classifier=classifier, metrics={}, **changed), "1.0.0"
    )


def test_a_real_table_in_space(spatial: Scenario, quadruped: Path, tmp_path: Path) -> None:
    searched = guided(spatial, budget=6, restarts=1)
    done = run(searched, quadruped, tasks=1, seed=2, runs=tmp_path)
    rows = {row["method"]: row for row in done["rows"]}
    assert list(rows) == ["guided", *METHODS]
    assert rows["guided"]["successful"] and rows["guided"]["violation"] <= 1e-6
    assert len({rows[method]["pattern"] for method in METHODS}) == 1
    for method in ("bounds_mean", "bounds_mean_dual"):
        assert rows[method]["successful"] and rows[method]["violation"] <= 1e-6, method
    # With 3 knots a phase the two methods may end in different local optima.
    assert rows["bounds_mean"]["cost"] == pytest.approx(rows["bounds_mean_dual"]["cost"], rel=2e-2)
    for method in METHODS:
        told = done["summary"][method]
        assert {"time_mean_s", "time_std_s", "successful", "consistent", "runs"} <= set(told)
        assert 0 < told["time_mean_s"] < 10, method
