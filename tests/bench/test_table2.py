from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gaitflow.bench import minlp
from gaitflow.bench.fixed_gait import METHODS, scenario_of
from gaitflow.bench.table2 import run
from gaitflow.scenario import Scenario


def guided(scenario: Scenario) -> Scenario:
    return scenario.model_copy(update={"strategy": scenario.strategy.model_copy(update={"name": "guided"})})


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
