"""Searches as one sampling hands them to a later one: published without a map, and begun from."""

from __future__ import annotations

from pathlib import Path

from gaitflow.config.scenario import Scenario
from gaitflow.dataset.collect import NotComplete, collect
from gaitflow.dataset.read import load_solutions
from gaitflow.dataset.restore import OtherSearches, restore
from gaitflow.files import make_folder
from gaitflow.pipeline.labelling import write_labels
from gaitflow.pipeline.sampling import chosen_tasks, written_rounds
from gaitflow.pipeline.workspace import Run, Workspace
from gaitflow.publishing.dataset import publish_dataset
from gaitflow.publishing.find import version_folder
from gaitflow.publishing.verify_dataset import verify_dataset
from gaitflow.sampling.rounds import Round, askings, rounds_from, was_stopped
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import plan_cold


def publish_searches(workspace: Workspace, scenario: Scenario) -> Path:
    """Publish the searches of a map that is not made yet as a dataset; returns its folder.

    Of an adaptive sampling these are the tasks searched so far; a grid has to be complete. Raises NotComplete,
    WriteError.
    """
    run = workspace.run(scenario)
    store, searches = UnitStore(run.folder), Run(run.folder / "searches")
    chosen, asked, rounds = None, 0, list[Round]()
    if scenario.tasks.adaptive is not None:
        stored = store.solved()
        units, rounds = plan_cold(scenario, chosen_tasks(run, scenario)), written_rounds(run, scenario)
        chosen = [unit.tasks[0] for unit in units if unit.digest in stored]
        if not chosen:
            raise NotComplete(f"{scenario.name}: nothing is searched yet; run gaitflow solve {scenario.name} first")
        asked = askings(rounds)
        rounds = rounds if was_stopped(rounds, chosen) else []
    make_folder(searches.folder)
    written = [one.as_data(scenario.tasks.space) for one in rounds]
    collect(store, scenario, chosen, target=searches.solutions, askings=asked, rounds=written)
    write_labels(searches, scenario)
    return publish_dataset(workspace.datasets, searches.solutions, searches.labels, searches.gait_costs)


def begin_from(store: UnitStore, scenario: Scenario, dataset: Path) -> list[Round]:
    """The first rounds of a sampling, from a published dataset whose searches the store has from now on.

    They are one round of its tasks; or its own rounds where it was published in the middle of one, so that the sampling
    goes on where it was stopped. `dataset` is a version's folder or one of versions. Raises ValueError when it is not
    sound or of other searches.
    """
    folder = version_folder(dataset)
    if faults := verify_dataset(folder):
        raise ValueError(f"{folder}: is not sound: {faults[0]}; gaitflow verify {folder} lists all that is wrong")
    solutions = load_solutions(folder)
    try:
        tasks = restore(store, scenario, solutions)
    except OtherSearches as error:
        raise OtherSearches(f"{folder}: {error}") from None
    if "rounds" not in solutions.record:
        return [Round("known", tuple(tasks), askings=int(solutions.record.get("askings", 0)))]
    rounds = rounds_from(solutions.record["rounds"], scenario.tasks.space)
    if not set(tasks) <= {task for one in rounds for task in one.tasks}:
        raise ValueError(f"{folder}: it has searches of tasks that its rounds lack")
    return rounds
