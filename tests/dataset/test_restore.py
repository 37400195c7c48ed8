"""The searches of a published dataset become parts of another run's store, if that run would have made them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from small_units import filled

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import Task
from gaitflow.dataset import Solutions, load_solutions
from gaitflow.dataset import restore as module
from gaitflow.dataset.collect import collect
from gaitflow.dataset.restore import OtherSearches, restore
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units

Make = Callable[[Unit], list[Solution]]


@pytest.fixture
def adaptive(scenario: Scenario) -> Scenario:
    return changed(scenario, {"tasks": scenario.as_data()["tasks"] | {"held_out": 0, "sampling": {"start": 5}}})


def changed(scenario: Scenario, values: dict[str, object]) -> Scenario:
    return Scenario.from_data(scenario.as_data() | values, "test")


def a_dataset(store: UnitStore, scenario: Scenario, make_solutions: Make) -> tuple[Solutions, list[Task]]:
    chosen = list(tasks_of(scenario))
    filled(store, plan_units(scenario, chosen), make_solutions)
    return load_solutions(collect(store, scenario, chosen, set(chosen[:2]))), chosen


def test_a_restored_store_has_the_same_units_and_makes_the_same_dataset(
    store: UnitStore, tmp_path: Path, adaptive: Scenario, make_solutions: Make
) -> None:
    first, chosen = a_dataset(store, adaptive, make_solutions)
    other = UnitStore(tmp_path / "other")
    renamed = changed(adaptive, {"name": "renamed"})
    assert restore(other, renamed, first) == sorted(chosen), "those of a certificate, too, as they were chosen"
    assert other.solved() == store.solved() and other.validate_all(plan_units(renamed, chosen)) == {}
    again = load_solutions(collect(other, adaptive, chosen, set(chosen[:2])))
    assert repr(again.table.to_pylist()) == repr(first.table.to_pylist())
    assert again.record["made_by"] == first.record["made_by"]
    assert again.record["solver_options"] == first.record["solver_options"]
    assert restore(other, renamed, first) == sorted(chosen), "once more changes nothing"


def test_each_part_says_who_solved_it(
    store: UnitStore, tmp_path: Path, adaptive: Scenario, make_solutions: Make
) -> None:
    chosen = list(tasks_of(adaptive))
    units = plan_units(adaptive, sorted(chosen))
    for number, unit in enumerate(units):
        store.write(unit, make_solutions(unit), {}, {"code": {}, "cpu": f"processor {number % 2}"})
    restore(UnitStore(tmp_path / "other"), adaptive, load_solutions(collect(store, adaptive, chosen)))
    makers = [UnitStore(tmp_path / "other").read_with_record(unit)[1]["made_by"]["cpu"] for unit in units]
    assert makers == [f"processor {number % 2}" for number in range(len(units))]


@pytest.mark.parametrize("field", ["robot", "strategy", "transcription"])
def test_searches_of_another_problem_are_refused(
    store: UnitStore, tmp_path: Path, adaptive: Scenario, make_solutions: Make, field: str
) -> None:
    first, _ = a_dataset(store, adaptive, make_solutions)
    data = adaptive.as_data()
    values = {
        "robot": data["robot"] | {"mass": data["robot"]["mass"] + 1},
        "strategy": data["strategy"] | {"restarts": 7},
        "transcription": data["transcription"] | {"min_phase_fraction": 0.11},
    }
    other = UnitStore(tmp_path / "other")
    with pytest.raises(OtherSearches, match="another robot, problem or strategy"):
        restore(other, changed(adaptive, {field: values[field]}), first)
    assert not other.solved()


def test_searches_of_other_code_are_refused(
    store: UnitStore, tmp_path: Path, adaptive: Scenario, make_solutions: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, _ = a_dataset(store, adaptive, make_solutions)
    code = {"code": "0" * 64, "casadi": "9"}
    monkeypatch.setattr("gaitflow.store.units.solver_version", lambda: code)
    monkeypatch.setattr(module, "solver_version", lambda: code)
    with pytest.raises(OtherSearches, match="other solver code"):
        restore(UnitStore(tmp_path / "other"), adaptive, first)


def test_a_grid_is_no_sampling(
    store: UnitStore, tmp_path: Path, scenario: Scenario, adaptive: Scenario, make_solutions: Make
) -> None:
    filled(store, plan_units(scenario), make_solutions)
    with pytest.raises(OtherSearches, match="no adaptive sampling"):
        restore(UnitStore(tmp_path / "other"), adaptive, load_solutions(collect(store, scenario)))


def test_a_motion_that_was_dropped_stays_away(
    store: UnitStore, tmp_path: Path, adaptive: Scenario, make_solutions: Make
) -> None:
    def thinned(unit: Unit) -> list[Solution]:
        return [replace(row, trajectory=None, multipliers=None) for row in make_solutions(unit)]

    first, chosen = a_dataset(store, adaptive, thinned)
    other = UnitStore(tmp_path / "other")
    restore(other, adaptive, first)
    table = other.read(plan_units(adaptive, chosen)[0])
    assert table["base"].null_count == len(table) and "solved" in table["status"].to_pylist()
