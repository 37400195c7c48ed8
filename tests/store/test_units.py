from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gaitflow.config.scenario import Scenario, digest_of, load_scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core import task as task_module
from gaitflow.core.task import AXES, Axis
from gaitflow.store import units as module
from gaitflow.store.units import Unit, plan_exhaustive, plan_units

Edit = Callable[[dict[str, Any]], Any]


def digests(scenario: Scenario, edit: Edit = lambda data: None) -> set[str]:
    data = scenario.as_data()
    edit(data)
    return {unit.digest for unit in plan_units(Scenario.from_data(data, "test"))}


def bonmin(data: dict[str, Any], restarts: int = 12, seed: int = 3) -> None:
    data["strategy"] |= {"name": "bonmin", "restarts": restarts, "seed": seed}


def test_chains_hold_one_duration_and_rising_speeds(units: tuple[Unit, ...]) -> None:
    grid = [unit for unit in units if unit.tasks[0].split == "grid"]
    assert [len(unit.tasks) for unit in grid] == [2, 1, 2, 1]
    for unit in grid:
        assert len({task.cycle_duration for task in unit.tasks}) == 1
        assert [task.speed for task in unit.tasks] == sorted(task.speed for task in unit.tasks)
    assert [len(unit.tasks) for unit in units if unit.tasks[0].split == "held_out"] == [2, 1]


@pytest.mark.parametrize("strategy", ["patterns", "bonmin"])
def test_every_task_and_seed_is_in_exactly_one_unit(scenario: Scenario, strategy: str) -> None:
    data = scenario.as_data()
    if strategy == "bonmin":
        bonmin(data)
    planned = Scenario.from_data(data, "test")
    seeds: list[int | None] = [None] if strategy == "patterns" else list(range(3, 15))
    slots = [(task, seed) for unit in plan_units(planned) for task in unit.tasks for seed in unit.seeds or (None,)]
    assert len(slots) == len(set(slots))
    assert set(slots) == {(task, seed) for task in tasks_of(planned) for seed in seeds}


def test_more_restarts_keep_the_units_solved_before(scenario: Scenario) -> None:
    assert digests(scenario, lambda d: bonmin(d, 10)) < digests(scenario, lambda d: bonmin(d, 20))


@pytest.mark.parametrize(
    "edit",
    [
        lambda data: data.update(description="other words", name="other"),
        lambda data: data["learning"].update(folds=7, max_epochs=5),
        lambda data: data["robot"].update(source="measured again"),
    ],
)
def test_what_changes_no_solution_changes_no_unit(scenario: Scenario, edit: Edit) -> None:
    assert digests(scenario, edit) == digests(scenario)


@pytest.mark.parametrize(
    "edit",
    [
        lambda data: data["robot"].update(mass=15.0),
        lambda data: data["tasks"]["axes"].update(slope=5.0),
        lambda data: data["tasks"]["axes"].update(friction=0.5),
        lambda data: data["transcription"].update(integrator="midpoint"),
        lambda data: data["objective"].update(tilt=1.0),
        lambda data: data["transcription"].update(knots_per_phase=3),
        lambda data: data.update(stances_per_leg=None),
        lambda data: data["strategy"].update(restarts=9),
        lambda data: data["strategy"].update(seed=9),
    ],
)
def test_what_changes_a_solution_changes_every_unit(scenario: Scenario, edit: Edit) -> None:
    assert not digests(scenario, edit) & digests(scenario)


def test_another_row_of_the_grid_adds_units_and_keeps_the_rest(scenario: Scenario) -> None:
    def add_row(data: dict[str, Any]) -> None:
        data["tasks"]["held_out"] = 0
        data["tasks"]["axes"]["cycle_duration"] = {"start": 0.4, "stop": 2.0, "count": 3}

    before = digests(scenario, lambda data: data["tasks"].update(held_out=0))
    assert before < digests(scenario, add_row)


def test_json_is_complete_and_comes_back_equal(scenario: Scenario, units: tuple[Unit, ...]) -> None:
    for unit in units:
        again = Unit.from_data(json.loads(json.dumps(unit.as_data())))
        assert again == unit and again.digest == unit.digest
        rebuilt = again.scenario
        assert rebuilt.objective == scenario.objective and rebuilt.transcription == scenario.transcription
        assert rebuilt.robot.mass == scenario.robot.mass and rebuilt.stances_per_leg == scenario.stances_per_leg
        assert rebuilt.strategy.restarts == scenario.strategy.restarts
        assert rebuilt.problem_digest == scenario.problem_digest


def sloped(data: dict[str, Any]) -> None:
    data["tasks"] = {
        "axes": {
            "speed": {"start": 0.1, "stop": 2.1, "count": 3},
            "cycle_duration": {"start": 0.4, "stop": 1.2, "count": 2},
            "slope": {"start": -10.0, "stop": 10.0, "count": 3},
        },
        "held_out": 3,
    }


def test_a_third_axis_makes_more_chains_of_neighbouring_speeds(scenario: Scenario) -> None:
    data = scenario.as_data()
    sloped(data)
    units = plan_units(Scenario.from_data(data, "test"))
    grid = [unit.tasks for unit in units if unit.tasks[0].split == "grid"]
    assert [len(chain) for chain in grid] == [2, 1] * 6
    for chain in grid:
        assert len({(task.cycle_duration, task["slope"]) for task in chain}) == 1
    assert {task["slope"] for chain in grid for task in chain} == {-10.0, 0.0, 10.0}
    # The slope is a parameter of the problem, also at the tasks where it is 0.
    assert all(unit.scenario.problem_digest == Scenario.from_data(data, "test").problem_digest for unit in units)


def test_where_the_speed_is_fixed_a_chain_runs_along_the_first_axis_with_a_range(scenario: Scenario) -> None:
    data = scenario.as_data()
    sloped(data)
    data["tasks"]["axes"]["speed"] = 0.5
    units = plan_units(Scenario.from_data(data, "test"))
    chains = [[task.cycle_duration for task in unit.tasks] for unit in units if unit.tasks[0].split == "grid"]
    assert chains == [[0.4, 1.2]] * 3


def test_an_axis_that_is_added_changes_no_unit_that_does_not_use_it(
    scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = digests(scenario)
    tailwind = Axis("tailwind", "m/s", -30.0, 30.0, 0.0, "speed of the air")
    monkeypatch.setitem(AXES, "tailwind", tailwind)
    monkeypatch.setattr(task_module, "AXIS_NAMES", tuple(AXES))
    assert digests(scenario) == before
    assert not digests(scenario, lambda data: data["tasks"]["axes"].update(tailwind=3.0)) & before


def test_a_bonmin_unit_carries_its_own_restarts(scenario: Scenario) -> None:
    data = scenario.as_data()
    bonmin(data, restarts=7, seed=3)
    first, second = plan_units(Scenario.from_data(data, "test"))[:2]
    assert first.seeds == (3, 4, 5, 6, 7) and second.seeds == (8, 9)
    assert (second.scenario.strategy.seed, second.scenario.strategy.restarts) == (8, 2)


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data.pop("seeds"),
        lambda data: data.update(tasks=[[1.0, 0.5, "grid"]]),
        lambda data: data["tasks"][0].update(split="train"),
        lambda data: data["tasks"][0].pop("friction"),
        lambda data: data["tasks"][0].update(slope=3.0),
        lambda data: data["tasks"][0].update(speed=float("nan")),
        lambda data: data["tasks"][0].update(cycle_duration=-1.0),
        lambda data: data["tasks"][0].update(speed=None),
        lambda data: data["problem"].update(axes="speed"),
        lambda data: data["problem"].update(axes=["speed", "speed"]),
        lambda data: data["problem"].update(axes=["speed", "weather"]),
        lambda data: data["problem"].update(axes=[["speed"]]),
        lambda data: data["problem"].pop("axes"),
        lambda data: data["problem"].pop("robot"),
        lambda data: data["problem"]["robot"].update(mass=-1.0),
    ],
)
def test_foreign_data_are_refused(units: tuple[Unit, ...], damage: Edit) -> None:
    data = units[0].as_data()
    damage(data)
    with pytest.raises(ValueError, match="not a unit of work"):
        _ = Unit.from_data(data).scenario


def test_code_version_is_part_of_the_digest(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    before = digests(scenario)
    monkeypatch.setattr(module, "solver_version", lambda: {"code": "other", "casadi": "0"})
    assert not before & digests(scenario)


GOLDEN = [
    ("quickstart", {}, 5, "466574df649ebfaa", "5e89468b43e504c2"),
    ("half-cheetah-flat-vibration", {}, 21, "15280ad808cb958d", "6c042467c6ed3853"),
    ("anymal-flat-vibration", {}, 16, "c4e5c9c8b6e6e151", "c8091e899477e177"),
    ("quickstart", {"name": "bonmin", "restarts": 7}, 60, "3abb93e47328c5a3", "095a07a0e2bd4839"),
    ("quickstart", {"name": "fixed_gait", "pattern": "0110/1100"}, 5, "8ce857fda40b8955", "c5334f7916b33620"),
]


def shipped(checkout: Path, name: str, strategy: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> Scenario:
    """A scenario of the project, planned with a solver's version that never changes."""
    monkeypatch.setattr(module, "solver_version", lambda: {"code": "0" * 64, "casadi": "3.8.0"})
    data = load_scenario(checkout / f"configs/scenarios/{name}.yaml").as_data()
    data["strategy"] |= strategy
    return Scenario.from_data(data, name)


@pytest.mark.parametrize(("name", "strategy", "count", "first", "together"), GOLDEN)
def test_names_of_stored_units_never_change(
    checkout: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    strategy: dict[str, Any],
    count: int,
    first: str,
    together: str,
) -> None:
    """These digests name files in stores that exist: another one here means that all is solved again."""
    units = plan_units(shipped(checkout, name, strategy, monkeypatch))
    assert (len(units), units[0].digest[:16]) == (count, first)
    assert digest_of([unit.digest for unit in units])[:16] == together


def test_names_of_the_certificate_s_units_never_change(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = shipped(checkout, "quickstart", {}, monkeypatch)
    slow, fast = plan_units(scenario)[0].tasks[:2]
    units = plan_exhaustive(scenario, {slow: 12.5, fast: 1e-7}, 3)
    assert digest_of([unit.digest for unit in units])[:16] == "d262c0d89933afed"


def test_a_unit_s_name_is_the_digest_of_its_data(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, strategy, *_ in GOLDEN:
        for unit in plan_units(shipped(checkout, name, strategy, monkeypatch)):
            assert unit.digest == digest_of(unit.as_data())
            assert Unit.from_data(json.loads(json.dumps(unit.as_data()))).digest == unit.digest
