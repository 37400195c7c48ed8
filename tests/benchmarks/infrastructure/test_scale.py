from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.infrastructure import scale
from benchmarks.infrastructure.scale import WORKERS, Point, driver, points, steady, summarise
from gaitflow.config.scenario import Scenario
from gaitflow.store.journal import Entry, read_journal
from gaitflow.store.parts import UnitStore


def journal(solver: str, *spans: tuple[float, float]) -> list[Entry]:
    entries = []
    for start, end in spans:
        unit = f"{solver}{start}"
        entries.append(Entry("start", unit, start, solver))
        entries.append(Entry("stored", unit, end, solver, wall_s=end - start))
    return entries


def test_the_time_in_which_all_workers_could_be_busy() -> None:
    """From 2 s, when the second worker begins, to 12 s, when the fourth unit from the end is begun."""
    one = journal("a", (0.0, 4.0), (5.0, 9.0), (10.0, 14.0), (14.0, 15.0), (15.0, 16.0))
    other = journal("b", (2.0, 7.0), (7.0, 12.0), (12.0, 13.0), (13.0, 14.0), (14.5, 15.0))
    entries = sorted(one + other, key=lambda entry: entry.time)
    per_s, busy = steady(entries, 2)
    assert per_s == pytest.approx(4 / 10), "those stored at 4, 7, 9, 12"
    assert busy == pytest.approx((8 + 10) / 20)
    with pytest.raises(ValueError, match="2 units are too few for 2 workers"):
        steady(journal("a", (0.0, 4.0)) + journal("b", (1.0, 3.0)), 2)


def test_rows_take_about_the_same_time() -> None:
    every = points(100_000)
    assert Point(200, 1.0, 3750) in every and Point(10, 10.0, 50) in every and Point(400, 10.0, 2000) in every
    assert {point.workers for point in every} == set(WORKERS)
    assert [(point.units, point.stores) for point in every][-2:] == [(100_000, False), (2000, True)]


def test_what_takes_the_driver_s_time_and_up_to_how_many_workers_are_kept_busy() -> None:
    """Of 2 s once, 1 ms a unit and 0.1 ms a worker and second."""
    rows = [
        {"workers": workers, "unit_s": unit_s, "units": units, "wall_s": 30.0, "busy": busy, "per_s": units / 30}
        | {"driver_ms": 2e3 / units + 1.0 + 0.1 * workers * 30 / units}
        for workers, unit_s, units, busy in ((50, 1.0, 1500, 0.97), (100, 1.0, 2700, 0.91), (200, 0.1, 4500, 0.6))
    ]
    told = summarise(rows)
    fitted = (told["driver_once_s"], told["driver_ms_per_unit"], told["driver_ms_per_worker_and_s"])
    assert fitted == pytest.approx((2.0, 1.0, 0.1)) and told["driver_fit_least"] == pytest.approx(1.0)
    assert told["workers_90_percent_busy"] == {"0.1 s": None, "1 s": 100, "10 s": None}
    assert told["seen_per_s"] == 150.0


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_stand_ins_take_a_run_to_its_end(scenario: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = [Point(3, 0.2, 30), Point(3, 0.2, 30, stores=True)]
    monkeypatch.setattr(scale, "points", lambda many: few)
    monkeypatch.setattr(scale, "IN_A_PROCESS", 2)
    done = scale.run(scenario, runs=tmp_path)
    assert [(row["workers"], row["units"], row["stores"]) for row in done["rows"]] == [(3, 30, False), (3, 30, True)]
    for row in done["rows"]:
        assert 0 < row["per_s"] < 1.5 * row["ideal_per_s"] == 1.5 * 15 and 0 < row["busy"] <= 1
        assert row["driver_ms"] > 0 and row["files"] > 3 * 3
    assert len(list((tmp_path / "bench").iterdir())) == 1, "the rows, and nothing else"
    json.dumps(done, allow_nan=False)
    measure = driver(scenario.as_data(), str(tmp_path / "run"))
    measure(**vars(replace(few[1], units=12)))
    store = UnitStore(tmp_path / "run")
    stored = {entry.unit for entry in read_journal(store.folder / "journal") if entry.kept}
    assert stored == store.solved() and len(stored) == 12
