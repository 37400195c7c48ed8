"""What a report tells of one task: its numbers, what came next, and what the map chooses there."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.task_space import TaskSpace
from gaitflow.dataset.labels import gait_costs
from gaitflow.report.decisions import Select
from gaitflow.report.map_tasks import SPLIT_WORDS
from gaitflow.report.tables import number, percent, refined
from gaitflow.search.solution import Solution

RIVALS = 8  # gaits that are told beside the best one
Pairs = list[tuple[str, str]]


def task_facts(
    labels: pd.DataFrame, space: TaskSpace, gaits: Sequence[str], select: Select | None
) -> dict[Hashable, Pairs]:
    """(name, value) pairs of each task, by the label's index; `gaits` and `select` as in `write_report`."""
    judged, chosen = refined(labels), _chosen(labels, space, gaits, select)
    rows = zip(labels.index, labels.to_dict("records"), strict=True)
    return {row: _facts(label, judged, chosen.get(row)) for row, label in rows}


def _facts(label: Mapping[Any, Any], judged: bool, chosen: str | None) -> Pairs:
    told = [("split", SPLIT_WORDS[label["split"]])]
    if label["status"] != "solved":
        return [*told, ("status", str(label["status"]))]
    told += [("cost", number(label["cost"])), ("margin", percent(label["margin"]))]
    if judged:
        told.append(("cost error", f"{percent(label['cost_error'])}, {'' if label['resolved'] else 'not '}resolved"))
    if len(label["ties"]) > 1:
        told.append(("gaits that tie", ", ".join(label["ties"])))
    if label["label"] != label["gait"]:
        told.append(("learnt as", str(label["label"])))
    if chosen is not None:
        told.append(("the map's choice", chosen))
    return [*told, ("pattern", str(label["pattern"]))]


def _chosen(labels: pd.DataFrame, space: TaskSpace, gaits: Sequence[str], select: Select | None) -> dict[Hashable, str]:
    """What the map chooses at each task, by the label's index; nothing without a map."""
    if select is None:
        return {}
    answers = np.asarray(select({axis: labels[axis].to_numpy(dtype=float) for axis in space.ranged}))
    names = ["none, outside its domain" if index < 0 else gaits[index] for index in answers]
    return dict(zip(labels.index, names, strict=True))


def rivals(labels: pd.DataFrame, solutions: Sequence[Solution], scenario: Scenario) -> dict[Hashable, Pairs]:
    """(gait, by what share it is dearer) of the next best gaits of each solved task, by the label's index.

    The RIVALS cheapest; the runner-up alone where no solves are at hand.
    """
    columns = [*scenario.tasks.space.columns, "split"]
    costs = {}
    if solutions:
        table = gait_costs(_scalars(solutions, scenario.tasks.space), scenario.robot.leg_names)
        costs = {_key(key): group for key, group in table.groupby(columns, sort=False)}
    solved = labels[labels["status"] == "solved"]
    return {
        row: _dearer(label, costs.get(_key(label[column] for column in columns)))
        for row, label in zip(solved.index, solved.to_dict("records"), strict=True)
    }


def _dearer(label: Mapping[Any, Any], costs: pd.DataFrame | None) -> Pairs:
    if costs is None:
        return [(str(label["runner_up"]), percent(label["margin"]))] if math.isfinite(label["margin"]) else []
    others = costs[costs["gait"] != label["gait"]].head(RIVALS)
    return [(str(gait), percent(excess)) for gait, excess in zip(others["gait"], others["excess"], strict=True)]


def _key(values: Any) -> tuple[object, ...]:
    return tuple(round(value, 9) if isinstance(value, float) else value for value in values)


def _scalars(solutions: Sequence[Solution], space: TaskSpace) -> pd.DataFrame:
    """A row a solution: its task on the tables' columns, and everything but its arrays."""
    names = [each.name for each in fields(Solution) if each.name not in ("task", "trajectory", "multipliers")]
    rows = [
        (*solution.task.on(space.columns), solution.task.split, *(getattr(solution, name) for name in names))
        for solution in solutions
    ]
    return pd.DataFrame(rows, columns=[*space.columns, "split", *names])
