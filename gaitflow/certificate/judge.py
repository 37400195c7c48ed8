"""What a map's pick costs at a task, beside the best gait that a search of that task finds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from gaitflow.core.task import Task
from gaitflow.tables.schema import task_columns

DEARER = 0.01  # relative: a pick that costs more than this above the best is a failure
INFEASIBLE = float("inf")


@dataclass(frozen=True)
class Verdict:
    """A pick judged: `excess` is its cost over the least that the search found, less 1; infinite without a motion.

    Negative where the search missed something cheaper. `pick` and `best`, the search's, are keys of gaits; `best` is ""
    when the search found no motion at all.
    """

    task: Task
    pick: str
    best: str
    excess: float

    @property
    def dearer(self) -> bool:
        """Whether the pick is a failure: too dear, or without a motion."""
        return self.excess > DEARER

    @property
    def infeasible(self) -> bool:
        """Whether the pick has no known motion."""
        return self.excess == INFEASIBLE


PickCost = Callable[[Task], float | None]  # of the pick on the scenario's mesh, unscaled; None without a motion


def judge_picks(tasks: list[Task], picks: list[str], costs: pd.DataFrame, pick_cost: PickCost) -> list[Verdict]:
    """A verdict a task; `costs` is the frame of `gaitflow.dataset.labels.gait_costs` of these tasks, searched.

    `picks` are keys of gaits, since the name of one depends on which others there are. `pick_cost` is asked where the
    search has no cost of the pick, or one that fails: the search may have missed the pick's own best motion, which the
    map's start leads to. The lesser cost counts.
    """
    axes = [name for name in task_columns(costs.columns) if name != "split"]
    known = {place: rows for place, rows in costs.groupby(axes, sort=False)}
    verdicts = []
    for task, pick in zip(tasks, picks, strict=True):
        rows = known.get(task.on(axes))
        of_pick = None if rows is None else rows[rows["gait_key"] == pick]
        excess = INFEASIBLE if of_pick is None or not len(of_pick) else float(of_pick["excess"].iloc[0])
        if excess > DEARER and (cost := pick_cost(task)) is not None:
            excess = min(excess, -1.0 if rows is None else cost / float(rows["cost"].min()) - 1)
        verdicts.append(Verdict(task, pick, "" if rows is None else str(rows["gait_key"].iloc[0]), excess))
    return verdicts
