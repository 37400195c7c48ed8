from __future__ import annotations

import json
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
from planted_child import PlantedChild

from benchmarks import child
from benchmarks.search import referee
from benchmarks.search.referee import draws, run, summarise, verdict
from benchmarks.search.tasks import task_of
from gaitflow.config.scenario import Range, Scenario, Tasks
from gaitflow.core.gaits import Pattern
from gaitflow.search.screen import why_impossible


def row(ours: float | None, theirs: float | None) -> dict[str, Any]:
    found = {
        "ours": {"cost": ours, "method": "interior_point" if ours else None, "solver_status": "", "cpu_s": 0.5},
        "ipopt": {"cost": theirs, "solver_status": "", "iterations": 30, "cpu_s": 2.0},
    }
    return found | {"verdict": verdict(found)}


def test_every_pair_has_one_verdict() -> None:
    assert verdict(row(100.0, 100.005)) == verdict(row(100.005, 100.0)) == "equal"
    assert verdict(row(99.0, 100.0)) == "cheaper"
    assert verdict(row(101.0, 100.0)) == "dearer"
    assert verdict(row(100.0, None)) == "missed_by_ipopt"
    assert verdict(row(None, 100.0)) == "failed_but_feasible"
    assert verdict(row(None, None)) == "infeasible"


def test_summary_counts_verdicts_and_their_worst() -> None:
    rows = [row(100.0, 100.0), row(90.0, 100.0), row(103.0, 100.0), row(1.0, None), row(None, 1.0), row(None, None)]
    told = summarise(rows)
    assert told["drawn"] == {"solved": 4, "failed": 2}
    assert (told["solved"], told["cheaper"], told["equal"], told["dearer"]) == (3, 1, 1, 1)
    assert (told["failed_but_feasible"], told["missed_by_ipopt"]) == (1, 1)
    assert told["cheaper_rel_max"] == pytest.approx(0.1)
    assert told["dearer_rel_max"] == pytest.approx(0.03)
    assert (told["cpu_ratio_solved"], told["cpu_ratio_failed"]) == (4.0, 4.0)
    assert summarise([])["cpu_ratio_solved"] is None


def test_draws_repeat_are_new_and_pass_the_screen(scenario: Scenario) -> None:
    drawn = list(islice(draws(scenario, 3), 40))
    assert drawn == list(islice(draws(scenario, 3), 40))
    assert drawn != list(islice(draws(scenario, 4), 40))
    assert len({tuple(row.values()) for row in drawn}) == 40
    for each in drawn:
        assert why_impossible(scenario, Pattern.from_text(each["pattern"]), task_of(scenario, each)) is None


def test_draws_end_where_there_is_nothing_new(scenario: Scenario) -> None:
    one = {"speed": Range(start=0.5, stop=0.5, count=1), "cycle_duration": 0.6}
    few = scenario.model_copy(update={"tasks": Tasks(axes=one)})
    assert len(list(draws(few, 0))) == 24


def test_a_small_real_comparison(scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(referee, "BATCH", 4)
    monkeypatch.setattr(referee, "FAILED", 0)
    done = run(scenario, tasks=6, seed=1, runs=tmp_path)
    summary = done["summary"]
    assert summary["drawn"] == {"solved": 6, "failed": 0}
    assert summary["solved"] + summary["missed_by_ipopt"] == 6
    assert summary["solved"] >= 5
    assert summary["dearer_rel_max"] < 0.5
    monkeypatch.setattr(child, "Child", PlantedChild)
    assert run(scenario, tasks=6, seed=1, runs=tmp_path)["rows"] == done["rows"]
    json.dumps(done, allow_nan=False)
