from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from small_units import filled

from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.config.tasks import tasks_of
from gaitflow.dataset import collect as module
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import NotComplete, collect, tasks_as_chosen
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

Make = Callable[[Unit], list[Solution]]


def key_of(row: Solution) -> tuple[str, float, float, str]:
    return row.task.split, row.task.cycle_duration, row.task.speed, row.pattern


@pytest.mark.parametrize("group", [1, 4, 1000])
def test_rows_do_not_depend_on_the_order_of_arrival(
    tmp_path: Path,
    scenario: Scenario,
    units: tuple[Unit, ...],
    make_solutions: Make,
    group: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = collect(filled(UnitStore(tmp_path / "a"), units, make_solutions, 1), scenario)
    monkeypatch.setattr(module, "ROWS_PER_GROUP", group)
    second = collect(filled(UnitStore(tmp_path / "b"), units, make_solutions, 2), scenario)
    tables = [pq.read_table(path).drop_columns(["wall_s", "cpu_s"]).to_pylist() for path in (first, second)]
    assert repr(tables[0]) == repr(tables[1]) and len(tables[0]) == 3 * len(tasks_of(scenario))


def test_rows_are_sorted_and_complete(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    solutions = load_solutions(collect(filled(store, units, make_solutions), scenario))
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
    solutions = load_solutions(collect(filled(store, plan_units(sloped), make_solutions), sloped))
    frame = solutions.frame()
    assert list(frame.columns[:4]) == ["speed", "cycle_duration", "slope", "split"] and "friction" not in frame
    order = frame[["split", "slope", "cycle_duration", "speed", "pattern"]].to_numpy().tolist()
    assert order == sorted(order) and set(frame["slope"][frame["split"] == "grid"]) == {-10.0, 0.0, 10.0}
    assert {row.task for row in solutions} == set(tasks_of(sloped))


def test_chosen_tasks_lead_back_to_their_units(store: UnitStore, scenario: Scenario, make_solutions: Make) -> None:
    data = scenario.as_data()
    data["tasks"] |= {"held_out": 0, "sampling": {"start": 5}}
    adaptive = Scenario.from_data(data, "test")
    chosen = tasks_of(adaptive)
    file = collect(filled(store, plan_units(adaptive, chosen), make_solutions), adaptive, chosen, set(chosen[:2]))
    solutions = load_solutions(file)
    assert [task.split for task in solutions.tasks()] == ["held_out"] * 2 + ["sampled"] * 3
    units = plan_units(adaptive, tasks_as_chosen(solutions))
    assert {unit.tasks[0] for unit in units} == set(chosen)
    digests = [unit.digest for unit in units]
    assert set(digests) == store.solved() and digest_of(sorted(digests)) == solutions.record["units_digest"]
    assert [unit.tasks for unit in units] == [(task,) for task in sorted(chosen)]


def test_record_holds_the_whole_scenario(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    record = load_solutions(collect(filled(store, units, make_solutions), scenario)).record
    assert Scenario.from_data(record["scenario"], "record") == scenario
    assert record["scenario_digest"] == digest_of(scenario.as_data())
    assert record["units"] == len(units) and record["solver_options"] == [{"tol": 1e-9}]


def test_an_unfinished_run_is_not_collected(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    filled(store, units[1:], make_solutions)
    with pytest.raises(NotComplete, match=f"1 of {len(units)} units are not solved"):
        collect(store, scenario)
    assert not (store.folder / "solutions.parquet").exists()


def test_a_damaged_part_is_named_and_the_old_dataset_stays(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], make_solutions: Make
) -> None:
    target = collect(filled(store, units, make_solutions), scenario)
    before = target.read_bytes()
    part = store.path(units[2].digest)
    part.write_bytes(part.read_bytes()[:500])
    with pytest.raises(NotComplete, match=f"1 damaged part.*quarantine.*{units[2].digest}"):
        collect(store, scenario)
    assert target.read_bytes() == before
    store.write(units[2], make_solutions(units[2]), {"tol": 1e-9})
    assert collect(store, scenario) == target


def test_tasks_that_were_chosen_tell_in_the_end_what_they_were_for(
    store: UnitStore, scenario: Scenario, make_solutions: Make
) -> None:
    data = scenario.as_data()
    data["tasks"] |= {"held_out": 0, "sampling": {"start": 5}}
    adaptive = Scenario.from_data(data, "test")
    chosen = list(tasks_of(adaptive))
    units = plan_units(adaptive, chosen)
    assert [unit.tasks for unit in units] == [(task,) for task in chosen], "a unit a task"
    path = collect(filled(store, units, make_solutions), adaptive, chosen, {chosen[3]})
    solutions = load_solutions(path)
    assert [task.split for task in solutions.tasks()].count("held_out") == 1
    apart = [row for row in solutions if row.task.split == "held_out"]
    assert len(apart) == 3 and {row.task.values for row in apart} == {chosen[3].values}
    assert {row.split for row in solutions} == {"sampled", "held_out"}
    original = make_solutions(units[3])[0]
    assert apart[0].trajectory is not None and original.trajectory is not None
    assert any((row.base == original.trajectory.base).all() for row in apart if row.base is not None)
