from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.infrastructure.speedup import measured, run, spread, summarise
from benchmarks.measure import measure
from gaitflow.config.cluster import Profile
from gaitflow.config.scenario import Scenario
from gaitflow.pipeline.workspace import Workspace
from gaitflow.store.journal import Entry
from gaitflow.store.units import plan_units


def test_tasks_are_spread_over_the_scenario_s_rectangle(scenario: Scenario) -> None:
    cut = spread(scenario, 36)
    wide, cut_wide = scenario.tasks.ranges["speed"], cut.tasks.ranges["speed"]
    assert (cut_wide.start, cut_wide.stop) == (wide.start, wide.stop)
    units = plan_units(cut)
    assert {len(unit.tasks) for unit in units} == {1}, "the last unit of a long one leaves the other worker idle"
    assert len(units) == 36


def entry(unit: str, solver: str, start: float, end: float) -> list[Entry]:
    cpu = 0.9 * (end - start)
    return [Entry("start", unit, start, solver), Entry("stored", unit, end, solver, cpu, end - start, True)]


def test_speedup_and_what_explains_it() -> None:
    one = measured([*entry("a", "x", 0, 10), *entry("b", "x", 10, 20), *entry("c", "x", 20, 30)], 1)
    two = measured([*entry("a", "x", 5, 15), *entry("b", "y", 5, 20), *entry("c", "x", 15, 25)], 2)
    assert (one["span_s"], two["span_s"], two["units"]) == (30, 20, 3)
    assert (one["busy"], two["busy"]) == (1.0, pytest.approx(35 / 40))
    told = summarise([one, two, one])
    assert (told["speedup"], told["efficiency"]) == (1.5, 0.75)
    assert told["cpu_ratio"] == pytest.approx(35 / 30)


def test_a_machine_that_slows_down_is_held_against_both_of_its_speeds() -> None:
    first, last = measured(entry("a", "x", 0, 30), 1), measured(entry("a", "x", 0, 50), 1)
    told = summarise([first, measured([*entry("a", "x", 0, 10), *entry("b", "y", 0, 20)], 2), last])
    assert (told["speedup_least"], told["speedup"], told["speedup_most"]) == (1.5, 2.0, 2.5)


@pytest.mark.slow
def test_two_workers_are_faster_where_units_only_wait(scenario: Scenario, tmp_path: Path) -> None:
    done = run(scenario, 8, runs=tmp_path, solve="benchmarks.infrastructure.idle:one_second")
    assert done["bench"] == "speedup" and [row["workers"] for row in done["rows"]] == [1, 2, 1]
    assert {row["units"] for row in done["rows"]} == {8}
    assert 1.2 < done["summary"]["speedup"] <= 2.2
    assert all(row["unit_wall_s_median"] == pytest.approx(1.0, abs=0.5) for row in done["rows"])
    assert list((tmp_path / "bench").iterdir()) == []
    json.dumps(done, allow_nan=False)


def test_no_other_bench_takes_a_profile(scenario: Scenario, tmp_path: Path) -> None:
    profile = Profile(name="here", walltime="01:00:00", jobs=2)
    with pytest.raises(ValueError, match="for `bench speedup` only"):
        measure("overhead", Workspace(tmp_path), scenario, None, 0, profile)
