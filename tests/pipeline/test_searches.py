"""Searches of a sampling that was stopped are published, and another run goes on where it was."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from small_units import quickstart, solutions_of

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core.task import Task
from gaitflow.dataset import load_solutions
from gaitflow.pipeline.searches import begin_from, publish_searches
from gaitflow.pipeline.workspace import Workspace
from gaitflow.sampling.rounds import Round, task_at
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_cold

NUMBER = 4  # tasks of the start


@pytest.fixture
def scenario(checkout: Path) -> Scenario:
    data = quickstart(checkout, (0.1, 2.1, 3), (0.4, 1.2, 2), held_out=0, tasks_per_unit=1).as_data()
    data["tasks"] |= {"sampling": {"start": NUMBER}}
    data["transcription"]["knots_per_phase"] = 2
    return Scenario.from_data(data, "test")


def stopped(workspace: Workspace, scenario: Scenario, rounds: list[Round], searched: list[Task]) -> Path:
    """The dataset of a sampling that was stopped with these rounds, when so many tasks were searched."""
    run = workspace.run(scenario)
    run.rounds.parent.mkdir(parents=True)
    run.rounds.write_text(json.dumps([one.as_data(scenario.tasks.space) for one in rounds]))
    store = UnitStore(run.folder)
    for unit in plan_cold(scenario, searched):
        store.write(unit, [row for row in solutions_of(unit) if row.trajectory is None], {})  # no motion is checked
    return publish_searches(workspace, scenario)


def fresh(scenario: Scenario, *speeds: float) -> tuple[Task, ...]:
    return tuple(task_at(scenario.tasks.space, (speed, 0.7)) for speed in speeds)


@pytest.mark.parametrize("searched", [NUMBER, NUMBER + 1, NUMBER + 2])
def test_an_unasked_certificate_is_gone_on_with(tmp_path: Path, scenario: Scenario, searched: int) -> None:
    start = Round("start", tuple(tasks_of(scenario)))
    rounds = [start, Round("certificate", fresh(scenario, 0.33, 1.27))]
    tasks = [task for one in rounds for task in one.tasks][:searched]
    dataset = stopped(Workspace(tmp_path), scenario, rounds, tasks)
    store = UnitStore(tmp_path / "other")
    assert begin_from(store, scenario, dataset) == rounds, "with the tasks that are still to be searched"
    assert store.solved() == {unit.digest for unit in plan_cold(scenario, tasks)}


def test_rounds_that_were_gone_through_become_one(tmp_path: Path, scenario: Scenario) -> None:
    tasks = tuple(tasks_of(scenario))
    dataset = stopped(Workspace(tmp_path), scenario, [Round("start", tasks)], list(tasks))
    assert "rounds" not in load_solutions(dataset).record
    assert begin_from(UnitStore(tmp_path / "other"), scenario, dataset) == [Round("known", tuple(sorted(tasks)))]


def test_rounds_that_lack_a_searched_task_are_refused(
    tmp_path: Path, scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    rounds = [Round("start", tuple(tasks_of(scenario))), Round("doubt", fresh(scenario, 0.33))]
    dataset = stopped(Workspace(tmp_path), scenario, rounds, list(rounds[0].tasks))
    read = load_solutions(dataset)
    other = [one.as_data(scenario.tasks.space) for one in rounds[1:]]
    monkeypatch.setattr(
        "gaitflow.pipeline.searches.load_solutions",
        lambda folder: type(read)(read.table, read.record | {"rounds": other}),
    )
    with pytest.raises(ValueError, match="searches of tasks that its rounds lack"):
        begin_from(UnitStore(tmp_path / "other"), scenario, dataset)


def test_a_refused_dataset_is_named(tmp_path: Path, scenario: Scenario) -> None:
    tasks = tuple(tasks_of(scenario))
    dataset = stopped(Workspace(tmp_path), scenario, [Round("start", tasks)], list(tasks))
    data = scenario.as_data()
    other = Scenario.from_data(data | {"strategy": data["strategy"] | {"restarts": 7}}, "test")
    with pytest.raises(ValueError, match=f"^{re.escape(str(dataset))}: its scenario quickstart has another"):
        begin_from(UnitStore(tmp_path / "other"), other, dataset)
