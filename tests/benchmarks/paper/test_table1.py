from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.paper.fixed_gait import scenario_of
from benchmarks.paper.table1 import METHODS, run
from benchmarks.search import search
from benchmarks.search.search import LOST
from gaitflow.runtime import GaitMap


def test_less_than_one_restart_is_refused(pristine: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="restarts = 0"):
        run(scenario_of(pristine), pristine, restarts=0, runs=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_lost_processes_are_failed_runs_and_a_second_run_solves_nothing(
    pristine: Path, tmp_path: Path, planted: Any
) -> None:
    scenario = scenario_of(pristine)
    first = run(scenario, pristine, tasks=2, seed=3, runs=tmp_path)
    assert planted.calls == 2 * (1 + 1 + 4)
    assert run(scenario, pristine, tasks=2, seed=3, runs=tmp_path)["rows"] == first["rows"]
    assert planted.calls == 12
    assert run(scenario, pristine, tasks=2, restarts=2, seed=3, runs=tmp_path)["summary"]["minlp"]["runs"] == 4
    assert planted.calls == 14
    for method in ("minlp", "bigm_random"):
        told = first["summary"][method]
        assert (told["successful"], told["consistent"], told["runs"], told["time_mean_s"]) == (0, 0, 2, 9.0)
        assert told["wall_mean_s"] == 10.0
    assert {r["status"] for r in first["rows"] if r["method"] == "minlp"} == {LOST}
    assert first["summary"]["bounds_mean"]["successful"] == 2
    inside = GaitMap.load(pristine).manifest.domain
    assert all(inside.contains(r) for r in first["rows"])
    json.dumps(first, allow_nan=False)


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_real_table_of_one_task(pristine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "BONMIN_LIMIT_S", 4.0)
    done = run(scenario_of(pristine), pristine, tasks=1, runs=tmp_path)
    assert len(done["rows"]) == len(METHODS)
    assert all(method["runs"] == 1 for method in done["summary"].values())
    assert done["summary"]["minlp"]["time_mean_s"] > 0.5
    assert done["summary"]["patterns"]["successful"] == 1
    assert done["summary"]["bounds_mean_dual"]["successful"] == 1
    assert done["summary"]["bounds_mean_dual"]["consistent_pattern"] == 1
    assert done["summary"]["bounds_mean_dual"]["time_mean_s"] < done["summary"]["patterns"]["time_mean_s"]
