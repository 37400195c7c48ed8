from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.infrastructure import store as module
from benchmarks.infrastructure.store import extrapolate, planned, run
from gaitflow.config.scenario import Scenario, Tasks
from gaitflow.store.units import plan_units


@pytest.mark.parametrize("size", [1, 7, 60, 1000])
def test_a_plan_of_any_size(scenario: Scenario, size: int) -> None:
    assert len({unit.digest for unit in plan_units(planned(scenario, size))}) == size


def test_a_plan_of_a_scenario_whose_map_chooses_its_tasks(scenario: Scenario) -> None:
    chosen = scenario.model_copy(update={"tasks": Tasks(axes=scenario.tasks.axes, sampling="adaptive")})
    assert planned(chosen, 60) == planned(scenario, 60)


def test_the_straight_line_through_the_last_two_rows() -> None:
    rows = [{"units": n, **dict.fromkeys(module.GROWING, 3.0 + 0.5 * n)} for n in (10, 100, 1000)]
    assert extrapolate(rows, 1_000_000) == dict.fromkeys(module.GROWING, pytest.approx(3.0 + 0.5 * 1_000_000))


def test_a_row_a_size_and_nothing_left_behind(
    scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "SIZES", (50, 1000))
    done = run(scenario, 100, tmp_path)
    assert [row["units"] for row in done["rows"]] == [50, 100]
    assert list(done["summary"]) == ["50 units", "100 units"]
    for row in done["rows"]:
        assert row["stored"] == row["files_before"] == row["units"] * 99 // 100
        assert (row["packs"], row["files_after"]) == (1, 1) and row["packed_mb"] > 0
        times = ("plan_s", "list_s", "left_s", "validate_ms_per_part", "remembered_s", "compact_s", "packed_decided_s")
        assert all(row[key] > 0 for key in times)
        assert row["plan_s"] <= row["decided_s"] <= 10 and 40 < row["decided_rss_mb"] <= 500
    assert "1000000 units" in done["notes"][-1] and "decided_rss_mb" in done["notes"][-1]
    assert list((tmp_path / "bench").iterdir()) == []
    json.dumps(done, allow_nan=False)
