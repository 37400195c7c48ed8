from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from loaded_modules import loaded_by

import gaitflow
from benchmarks.paper import minlp
from benchmarks.paper.minlp import run
from benchmarks.search.search import LOST
from gaitflow.config.scenario import Scenario


def short(scenario: Scenario, **strategy: Any) -> Scenario:
    """Three phases of three knots, so that a search takes seconds."""
    return scenario.model_copy(
        update={
            "transcription": scenario.transcription.model_copy(update={"phases": 3, "knots_per_phase": 3}),
            "strategy": scenario.strategy.model_copy(update=strategy),
        }
    )


def test_a_whole_run_beside_the_search(scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(minlp, "BUDGET_S", 60.0)
    done = run(short(scenario), runs=tmp_path)
    theirs, ours = done["rows"]
    assert (theirs["method"], ours["method"]) == ("minlp", "patterns")
    assert theirs["completed"] and theirs["gap"] == 0.0
    assert theirs["objective"] == pytest.approx(theirs["cost"], rel=1e-5), "unscaled"
    assert theirs["relaxation"] <= theirs["bound"] * (1 + 1e-9)
    assert theirs["incumbents"][-1]["objective"] == pytest.approx(theirs["objective"], rel=1e-6)
    assert 0 < theirs["first_incumbent_s"] <= theirs["incumbents"][-1]["time_s"] < 60
    assert theirs["cost_above_rel"] == pytest.approx((theirs["cost"] - ours["cost"]) / ours["cost"])
    assert theirs["violation"] <= 1e-6
    assert "log" not in theirs
    told = done["summary"]
    assert (told["completed"], told["minlp"]["runs"], told["nodes"]) == (1, 1, theirs["nodes"])
    assert (told["gap"], told["cost_above_rel"], told["budget_s"]) == (0.0, theirs["cost_above_rel"], 60.0)
    assert run(short(scenario), runs=tmp_path)["rows"] == done["rows"], "nothing was solved again"


def test_in_space_a_short_run_tells_how_far_it_came(
    spatial: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(minlp, "BUDGET_S", 2.0)
    done = run(short(spatial, name="guided", budget=4, restarts=1), runs=tmp_path)
    theirs, ours = done["rows"]
    assert not theirs["completed"]
    assert theirs["budget_s"] == 2.0 and theirs["cpu_s"] < 10
    assert theirs["programs"] > 1
    assert 0 < theirs["relaxation"] < ours["cost"]


def test_a_lost_run_is_told_and_another_search_does_not_repeat_it(
    scenario: Scenario, tmp_path: Path, planted: Any
) -> None:
    done = run(scenario, tasks=2, runs=tmp_path)
    assert planted.calls == 4
    rows = [row for row in done["rows"] if row["method"] == "minlp"]
    assert [row["status"] for row in rows] == [LOST, LOST]
    assert rows[0]["incumbents"] == [] and rows[0]["gap"] is None and rows[0]["cost_above_rel"] is None
    told = done["summary"]
    assert (told["minlp"]["successful"], told["minlp"]["time_mean_s"]) == (0, 9.0)
    assert (told["gap"], told["first_incumbent_s"], told["completed"]) == (None, None, 0)
    assert {row["problem"] for row in rows} == {scenario.problem_digest}
    more = scenario.model_copy(update={"strategy": scenario.strategy.model_copy(update={"restarts": 9})})
    again = run(more, tasks=2, runs=tmp_path)
    assert planted.calls == 6, "the searches, which depend on the restarts"
    assert [row["status"] for row in again["rows"][:2]] == [LOST, LOST]
    json.dumps(done, allow_nan=False)


def test_another_budget_is_another_run(
    scenario: Scenario, tmp_path: Path, planted: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(scenario, runs=tmp_path)
    monkeypatch.setattr(minlp, "BUDGET_S", 7200.0)
    assert run(scenario, runs=tmp_path)["rows"][0]["budget_s"] == 7200.0
    assert planted.calls == 3


# Of what Bonmin's search loads these decide nothing that takes an hour: files and names, and the polish of its pattern.
NOT_BONMIN = {
    "gaitflow", "gaitflow.config", "gaitflow.config.file", "gaitflow.config.frames", "gaitflow.config.sampling",
    "gaitflow.core", "gaitflow.core.errors", "gaitflow.core.names", "gaitflow.search", "gaitflow.search.attempts",
    "gaitflow.search.rows", "gaitflow.search.solution", "gaitflow.shipped", "gaitflow.solvers",
    "gaitflow.solvers.elements",
    "gaitflow.solvers.fixed_gait", "gaitflow.solvers.interior_point", "gaitflow.solvers.kkt",
    "gaitflow.solvers.options", "gaitflow.solvers.paths", "gaitflow.solvers.point", "gaitflow.solvers.program",
}  # fmt: skip


def test_a_run_depends_on_all_that_bonmin_solves_with() -> None:
    loaded = loaded_by("import gaitflow.search.bonmin")
    package = Path(gaitflow.__file__).parent
    covered = {path for pattern in minlp.BONMIN_SOURCES for path in package.glob(pattern)}
    assert {"gaitflow.core.layout", "gaitflow.core.task", "gaitflow.core.continuous"} <= loaded.keys()
    assert {name for name, file in loaded.items() if file not in covered} == NOT_BONMIN


def test_a_gait_is_called_by_its_name_of_today(
    scenario: Scenario, tmp_path: Path, planted: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(scenario, runs=tmp_path)["rows"][1]["gait"] == "gallop"
    monkeypatch.setattr(minlp, "gait_name", lambda gait, legs: f"new name of {gait.text}")
    assert run(scenario, runs=tmp_path)["rows"][1]["gait"] == "new name of 0011/0110"
    assert planted.calls == 2
