"""From a map's answer back to the solves that decided it, the commit and the machine that made them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Scenario, digest_of
from gaitflow.core.task import Task
from gaitflow.dataset.collect import tasks_as_chosen
from gaitflow.dataset.labels import gait_costs
from gaitflow.dataset.read import Solutions
from gaitflow.report.predicted import Known, known_gaits
from gaitflow.report.stored import nearest_task, scenario_of
from gaitflow.runtime import GaitMap
from gaitflow.runtime.artifact import Artifact
from gaitflow.store.units import plan_units

DECIDING = 2  # the gaits of a task between which a label decides
SOLVE = (
    "gait", "pattern", "status", "solver_status", "strategy", "start", "seed", "cost", "refined_cost", "refined_knots",
    "violation", "iterations", "cpu_s",
)  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What a map says at a task, and the solved tasks of its atlas beside it, the gait that it takes first.

    `known` is empty where the atlas knows no gait; then the classifier decided, with `probability`.
    """

    task: Mapping[str, float]
    gait: str | None
    probability: float
    known: tuple[Known, ...]


@dataclass(frozen=True)
class Decision:
    """What the dataset says at the map's solved task nearest to the one asked for; held-out tasks decide nothing.

    `solves` are the rows of the two gaits that cost least there, each as the columns SOLVE, the cheapest gait first;
    `statuses` counts all rows of the task. `unit` is the digest of the unit of work that solved it, None when the
    installed code is not the one that did; `made_by` what may have made it: code, packages, processor.
    """

    task: Task
    axes: tuple[str, ...]
    margin: float
    solves: tuple[Mapping[str, Any], ...]
    statuses: Mapping[str, int]
    unit: str | None
    made_by: tuple[Mapping[str, Any], ...]


def answer_of(artifact: Artifact, values: Mapping[str, float]) -> Answer:
    """The answer of a map at a task. Raises ValueError, OutOfDomain as `GaitMap.select` does."""
    asked: dict[str, Any] = dict(values)
    choice = GaitMap(artifact).select(**asked)
    known = known_gaits(artifact, choice.task) if choice.in_domain else ()
    return Answer(choice.task, choice.gait, choice.probability, known)


def decision_of(solutions: Solutions, values: Mapping[str, float]) -> Decision:
    """What decided at the map's stored task nearest to `values`. Raises ValueError as `nearest_task` does."""
    scenario, task = scenario_of(solutions), nearest_task(solutions, values, held_out=False)
    frame, axes = solutions.frame(), scenario.tasks.space.columns
    here = [frame[axis] == task[axis] for axis in axes]
    rows = frame[np.logical_and.reduce([*here, frame["split"] == task.split])]
    costs = gait_costs(rows, scenario.robot.leg_names)
    names = dict(zip(costs["gait_key"], costs["gait"], strict=True))
    margin = float(costs["excess"].iloc[1]) if len(costs) > 1 else np.inf
    counts = rows["status"].value_counts().sort_index()
    unit, made_by = _makers(solutions, scenario, task)
    return Decision(
        task=task,
        axes=axes,
        margin=margin,
        solves=tuple(_solves(rows, names, list(names)[:DECIDING])),
        statuses={str(status): int(count) for status, count in counts.items()},
        unit=unit,
        made_by=made_by,
    )


def _solves(rows: pd.DataFrame, names: Mapping[str, str], keys: list[str]) -> list[dict[str, Any]]:
    """The solved rows of some gaits, in their order, each gait's cheapest first."""
    solved = rows[(rows["status"] == "solved") & rows["gait"].isin(keys)]
    solved = solved.assign(place=solved["gait"].map(keys.index), gait=solved["gait"].map(names))
    solved = solved.sort_values(["place", "cost"], kind="stable")
    return [dict(zip(SOLVE, row, strict=True)) for row in solved[list(SOLVE)].itertuples(index=False, name=None)]


def _makers(solutions: Solutions, scenario: Scenario, task: Task) -> tuple[str | None, tuple[Mapping[str, Any], ...]]:
    """The unit of work of a task, and who made it: all makers of the dataset where it does not say which."""
    record = solutions.record
    makers, by_unit = tuple(record["made_by"]), record.get("units_made_by")
    try:
        units = plan_units(scenario, None if scenario.tasks.adaptive is None else tasks_as_chosen(solutions))
    except ConfigError:
        return None, makers
    searched = {one: index for index, unit in enumerate(units) for one in unit.tasks}
    place = searched.get(task, searched.get(task.mirrored()))
    if place is None or len(units) != record["units"]:
        return None, makers
    if by_unit is not None:
        makers = (makers[by_unit[place]],)
    unit = units[place].digest
    same = digest_of(sorted(each.digest for each in units)) == record["units_digest"]
    return (unit if same else None), makers
