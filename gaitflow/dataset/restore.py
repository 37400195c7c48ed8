"""Putting the searches of a published dataset back into the store of a run, so that a sampling can begin from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.core.task import Task
from gaitflow.dataset.collect import searched_rows, tasks_as_chosen
from gaitflow.dataset.read import Solutions
from gaitflow.search.solution import Solution
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_cold
from gaitflow.tables.solver_code import solver_version


class OtherSearches(ValueError):
    """A dataset holds no searches that this scenario, solved by this code, would make; the message says why."""


def restore(store: UnitStore, scenario: Scenario, solutions: Solutions) -> list[Task]:
    """Store the searches of a published dataset as parts of an adaptive sampling of `scenario`; returns their tasks.

    Each part says who solved it, as the dataset does. The dataset has dropped the motions of dear gaits, and so do the
    parts. Rows of mirror images are left out, since they follow from the others.

    Raises OtherSearches unless the scenario's problem, its strategy and the solver's code are those of the dataset;
    WriteError.
    """
    tasks = tasks_as_chosen(solutions)
    units = plan_cold(scenario, tasks)
    record = solutions.record
    if scenario.tasks.adaptive is None or record["units_digest"] != digest_of(sorted(unit.digest for unit in units)):
        raise OtherSearches(_difference(scenario, record))
    options = record["solver_options"]
    for unit, rows, maker in zip(units, _rows_of(units, solutions), _makers(record, len(units)), strict=True):
        store.write(unit, rows, options[0] if len(options) == 1 else {"one of": options}, maker)
    return tasks


def _rows_of(units: Sequence[Unit], solutions: Solutions) -> list[list[Solution]]:
    """The searched rows of each unit's task, with the split that it was chosen with."""
    rows: dict[Task, list[Solution]] = {unit.tasks[0]: [] for unit in units}
    for row in searched_rows(solutions):
        task = replace(row.task, split="sampled")
        rows[task].append(replace(row, task=task))
    return [rows[unit.tasks[0]] for unit in units]


def _makers(record: dict[str, Any], units: int) -> list[dict[str, Any]]:
    makers = record["made_by"]
    return [makers[number] for number in record.get("units_made_by", [0] * units)]


def _difference(scenario: Scenario, record: dict[str, Any]) -> str:
    """Why the units of a dataset are not those of the scenario."""
    theirs = record["scenario"]
    if scenario.tasks.adaptive is None or "sampling" not in theirs["tasks"]:
        return "its searches were chosen by no adaptive sampling, or the scenario has none (tasks.sampling: adaptive)"
    solver = solver_version()["code"]
    if any(maker["code"].get("solver") != solver for maker in record["made_by"]):
        return "it was searched with other solver code than this version's; solve anew, or install the version it names"
    return f"its scenario {theirs['name']} has another robot, problem or strategy than {scenario.name}"
