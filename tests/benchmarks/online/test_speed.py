"""Bench speed: plans beside IPOPT on every published map; the C++ planner needs cmake, cc and g++."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.document import plain
from benchmarks.online import speed


def test_ratios_are_of_each_task_and_of_the_slowest_plans() -> None:
    paths = {f"{way}_path": "fast" for way in ("plan", "compiled", "alone", "compiled_alone")}
    costs = {"plan_cost": 3.0, "alone_cost": 3.02}
    usual = {**paths, **costs, "compiled_ms": 1.0, "alone_ms": 0.5, "compiled_alone_ms": 0.25}
    usual |= {"cpp_ms": 0.5, "cpp_refined": True}
    timed = [{**usual, "plan_ms": 2.0, "ipopt_ms": 20.0, "ipopt_solved": True} for _ in range(98)]
    timed.append({**timed[0], "alone_path": "failed"})
    last = {"plan_path": "next:1", "plan_ms": 80.0, "ipopt_ms": 40.0, "ipopt_solved": False, "alone_cost": 3.04}
    last |= {"cpp_refined": False}
    timed.append({**usual, **last})
    row = speed.compared(timed)
    assert row["python"]["median"] == 10.0 and row["cpp"] == {"median": 40.0, "p99": 40.0}
    assert row["python"]["p99"] == pytest.approx(20.0 / row["python_ms"]["p99"]) and row["python_ms"]["p99"] > 2.0
    assert (row["ipopt_failed"], row["slow"], row["cpp_not_refined"], row["compiled_slow"]) == (1, 1, 1, 0)
    assert row["compiled"]["median"] == 20.0
    assert (row["alone"]["median"], row["compiled_alone"]["median"], row["alone_dearer"]) == (40.0, 80.0, 2)
    assert speed.summarise([{"map": "a 1.0.0", **row}])["reached"] == {"python": 1, "compiled": 1, "cpp": 1}


def test_a_workspace_without_maps_is_one_line(tmp_path: Path) -> None:
    for models in (tmp_path / "none", tmp_path):
        with pytest.raises(ValueError, match="holds no map; publish one first"):
            speed.run(models)


@pytest.mark.slow
def test_every_map_has_a_row(pristine: Path, tmp_path: Path) -> None:
    models = tmp_path / "models"
    shutil.copytree(pristine, models / pristine.parent.name / pristine.name)
    done = speed.run(models, tasks=8, runs=tmp_path / "runs")
    row = done["rows"][0]
    assert done["bench"] == "speed" and done["scenario"] is None and plain(done["rows"]) == done["rows"]
    assert row["map"] == f"{pristine.parent.name} {pristine.name}" and row["ipopt_failed"] <= 2
    assert row["cpp"]["median"] > row["compiled"]["median"] > row["python"]["median"] > 0
    assert speed.run(models, tasks=8, runs=tmp_path / "runs")["rows"] == done["rows"], "measured once"
