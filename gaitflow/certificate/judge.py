"""What a map's pick or plan costs at a task, beside the best gait that a search of that task finds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import pandas as pd

from gaitflow.core.task import Task
from gaitflow.tables.schema import task_columns

DEARER = 0.01  # relative: a pick that costs more than this above the best is a failure
INFEASIBLE = float("inf")


@dataclass(frozen=True)
class Verdict:
    """A pick or a plan judged: `excess` is its cost over that of the best gait that the search found, less 1.

    It is infinite without a motion, negative where the search missed something cheaper. `pick` and `best`, the
    search's, are keys of gaits; `best` is "" when the search found no motion at all.
    """

    task: Task
    pick: str
    best: str
    excess: float

    @property
    def dearer(self) -> bool:
        """Whether it is a failure: too dear, or without a motion."""
        return self.excess > DEARER

    @property
    def infeasible(self) -> bool:
        """Whether it has no known motion."""
        return self.excess == INFEASIBLE


PickCost = Callable[[Task], float | None]  # of the pick on the scenario's mesh, unscaled; None without a motion


def judge_picks(tasks: Sequence[Task], picks: Sequence[str], costs: pd.DataFrame, pick_cost: PickCost) -> list[Verdict]:
    """A verdict a task; `costs` is the frame of `gaitflow.dataset.labels.gait_costs` of these tasks, searched.

    `picks` are keys of gaits, since the name of one depends on which others there are. `pick_cost` is asked where the
    search has no cost of the pick, or one that fails: the search may have missed the pick's own best motion, which the
    map's start leads to. The lesser cost counts.
    """
    verdicts = []
    for task, pick, rows in zip(tasks, picks, _found(tasks, costs), strict=True):
        of_pick = None if rows is None else rows[rows["gait_key"] == pick]
        excess = INFEASIBLE if of_pick is None or not len(of_pick) else float(of_pick["excess"].iloc[0])
        if excess > DEARER and (cost := pick_cost(task)) is not None:
            excess = min(excess, _excess(cost, rows))
        verdicts.append(Verdict(task, pick, _best(rows), excess))
    return verdicts


def judge_plans(tasks: Sequence[Task], plans: Sequence[tuple[str, float | None]], costs: pd.DataFrame) -> list[Verdict]:
    """A verdict a task on its plan: the key of the gait, and the cost of the plan itself, None where there is no plan.

    `costs` as for `judge_picks`.
    """
    return [
        Verdict(task, gait, _best(rows), INFEASIBLE if cost is None else _excess(cost, rows))
        for task, (gait, cost), rows in zip(tasks, plans, _found(tasks, costs), strict=True)
    ]


def _found(tasks: Sequence[Task], costs: pd.DataFrame) -> list[pd.DataFrame | None]:
    """What the search found at each task, the best gait first; None where it found nothing."""
    axes = [name for name in task_columns(costs.columns) if name != "split"]
    known = {place: rows for place, rows in costs.groupby(axes, sort=False)}
    return [known.get(task.on(axes)) for task in tasks]


def _best(rows: pd.DataFrame | None) -> str:
    return "" if rows is None else str(rows["gait_key"].iloc[0])


def _excess(cost: float, rows: pd.DataFrame | None) -> float:
    """Over the best gait that was found, whose row is the first; -1 where nothing was.

    A finer mesh may have ruled out a gait that costs less on the scenario's. A cost from that gait's up to the best
    one's is neither dearer nor cheaper than what was found.
    """
    if rows is None:
        return -1.0
    best, least = float(rows["cost"].iloc[0]), float(rows["cost"].min())
    return cost / min(max(cost, least), best) - 1
