from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.config.tasks import tasks_of
from gaitflow.dataset import collect as module
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import NotComplete, collect, thin
from gaitflow.dataset.labels import gait_costs
from gaitflow.dataset.schema import HEAVY
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

Make = Callable[[Unit], list[Solution]]


def key_of(row: Solution) -> tuple[str, float, float, str]:
    return row.task.split, row.task.cycle_duration, row.task.speed, row.pattern


def fill(store: UnitStore, units: tuple[Unit, ...], make_solutions: Make, order_seed: int = 0) -> UnitStore:
    for unit in random.Random(order_seed).sample(units, len(units)):
        rows = make_solutions(unit)
        random.Random(order_seed).shuffle(rows)
        store.write(unit, rows, {"tol": 1e-9})
    return store


@pytest.mark.parametrize("group", [1, 4, 1000])
def test_rows_do_not_depend_on_the_order_of_arrival(
    tmp_path: Path,
    scenario: Scenario,
    units: tuple[Unit, ...],
    make_solutions: Make,
    group: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = collect(fill(UnitStore(tmp_path / "a"), units, make_solutions, 1), scenario)
    monkeypatch.setattr(module, "ROWS_PER_GROUP", group)
    second = collect(fill(UnitStore(tmp_path / "b"), units, make_solutions, 2), scenario)
    tables = [pq.read_table(path).drop_columns(["wall_s", "cpu_s"]).to_pylist() for path in (first, second)]
    assert repr(tables[0]) == repr(tables[1]) and len(tables[0]) == 3 * len(tasks_of(scenario))


def test_rows_are_sorted_and_complete(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    solutions = load_solutions(collect(fill(store, units, make_solutions), scenario))
    keys = [key_of(row) for row in solutions]
    assert keys == sorted(keys) and len(set(keys)) == len(keys)
    expected = {key_of(row): row for unit in units for row in make_solutions(unit)}
    assert set(keys) == set(expected)
    for key, row in zip(keys, solutions, strict=True):
        original = expected[key]
        assert repr(row.cost) == repr(original.cost)
        assert (row.base is None) == (original.trajectory is None)
        if original.trajectory is not None:
            for name in ("base", "forces", "end_forces"):
                assert (getattr(row, name) == getattr(original.trajectory, name)).all()


def test_a_third_axis_has_a_column_and_orders_the_rows(
    store: UnitStore, scenario: Scenario, make_solutions: Make
) -> None:
    data = scenario.as_data()
    data["tasks"]["axes"]["slope"] = {"start": -10.0, "stop": 10.0, "count": 3}
    sloped = Scenario.from_data(data, "test")
    solutions = load_solutions(collect(fill(store, plan_units(sloped), make_solutions), sloped))
    frame = solutions.frame()
    assert list(frame.columns[:4]) == ["speed", "cycle_duration", "slope", "split"] and "friction" not in frame
    order = frame[["split", "slope", "cycle_duration", "speed", "pattern"]].to_numpy().tolist()
    assert order == sorted(order) and set(frame["slope"][frame["split"] == "grid"]) == {-10.0, 0.0, 10.0}
    assert {row.task for row in solutions} == set(tasks_of(sloped))


def test_published_size_keeps_trajectories_of_the_cheapest_gaits(
    store: UnitStore,
    scenario: Scenario,
    units: tuple[Unit, ...],
    make_solutions: Make,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    collected = collect(fill(store, units, make_solutions), scenario)
    monkeypatch.setattr(module, "ROWS_PER_GROUP", 5)
    whole = load_solutions(collected)
    costs = gait_costs(whole.frame(), scenario.robot.leg_names)
    small = load_solutions(thin(collected, store.folder / "small.parquet", costs, gaits=1, dearer=0.0))
    assert small.record == whole.record
    pd.testing.assert_frame_equal(whole.frame(), small.frame())
    for _, rows in small.frame().groupby(["split", "cycle_duration", "speed"]):
        kept = [i for i in rows.index if small[i].trajectory is not None]
        assert kept == [rows[rows["status"] == "solved"]["cost"].idxmin()]
        assert small[kept[0]].multipliers is not None
        assert (small[kept[0]].feet == whole[kept[0]].feet).all()
    arrays = [name for name in small.table.column_names if name in HEAVY]
    assert small.table.select(arrays).nbytes < whole.table.select(arrays).nbytes


def test_multipliers_are_kept_near_the_best_in_single_precision(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    def two_gaits(unit: Unit) -> list[Solution]:
        return [replace(row, gait=row.pattern) for row in make_solutions(unit)]

    collected = collect(fill(store, units, two_gaits), scenario)
    whole = load_solutions(collected)
    costs = gait_costs(whole.frame(), scenario.robot.leg_names)
    small = load_solutions(thin(collected, store.folder / "small.parquet", costs, gaits=2, dearer=0.05))
    solved = whole.frame()["status"] == "solved"
    assert [row.trajectory is not None for row in small] == solved.tolist()
    # Costs are 100 v and 100 v + 1: within 5 % at 1.1 m/s and above, not at 0.1 m/s.
    least = [task.speed for unit in units for task in unit.tasks]
    kept = [row.task.speed for row in small if row.multipliers is not None]
    assert len(kept) == sum(1 + (speed >= 0.2) for speed in least)
    index = next(index for index, row in enumerate(small) if row.multipliers is not None)
    before, after = whole[index].multipliers, small[index].multipliers
    assert before is not None and after is not None
    assert (after.rows == before.rows.astype(np.float32)).all() and after.rows.dtype == np.float64


def test_record_holds_the_whole_scenario(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    record = load_solutions(collect(fill(store, units, make_solutions), scenario)).record
    assert Scenario.from_data(record["scenario"], "record") == scenario
    assert record["scenario_digest"] == digest_of(scenario.as_data())
    assert record["units"] == len(units) and record["solver_options"] == [{"tol": 1e-9}]


def test_an_unfinished_run_is_not_collected(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    fill(store, units[1:], make_solutions)
    with pytest.raises(NotComplete, match=f"1 of {len(units)} units are not solved"):
        collect(store, scenario)
    assert not (store.folder / "solutions.parquet").exists()


def test_a_damaged_part_is_named_and_the_old_dataset_stays(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    target = collect(fill(store, units, make_solutions), scenario)
    before = target.read_bytes()
    part = store.path(units[2].digest)
    part.write_bytes(part.read_bytes()[:500])
    with pytest.raises(NotComplete, match=f"1 damaged part.*quarantine.*{units[2].digest}"):
        collect(store, scenario)
    assert target.read_bytes() == before
    store.write(units[2], make_solutions(units[2]), {"tol": 1e-9})
    assert collect(store, scenario) == target


def test_a_damaged_dataset_is_not_thinned(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    collected = collect(fill(store, units, make_solutions), scenario)
    collected.write_bytes(collected.read_bytes()[:-50])
    with pytest.raises(ValueError, match="truncated"):
        thin(collected, store.folder / "small.parquet", pd.DataFrame(), gaits=1, dearer=0.1)
    assert not (store.folder / "small.parquet").exists()
