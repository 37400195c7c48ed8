"""The nominal motion of a gait's region: the mean of its trajectories, as the paper's section IV.B has it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gaitflow.core.gaits import NO_SYMMETRY, Pattern, Symmetry, gait_of
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.dataset.labels import MAX_VIOLATION
from gaitflow.search.solution import Solution
from gaitflow.tables.schema import task_columns

TaskKey = tuple[float, ...]  # values on the task columns of the labels
Pack = Callable[[Trajectory, float, str], Array]


@dataclass(frozen=True)
class WarmStart:
    """Where a solver starts for one gait: the means over a region, in the scaled variables of its fixed-gait NLP.

    Being scaled (durations as fractions of the cycle, for one), the means hold for every task of the region.
    """

    gait: str
    pattern: str  # pattern that the means belong to
    tasks: int  # how many solutions were averaged
    primal: Array  # [nw] decision vector w
    bounds: Array  # [nw] multipliers of the variable bounds, CasADi's signs
    rows: Array  # [ng] multipliers of the constraint rows


def region_means(
    labels: pd.DataFrame,
    solutions: Iterable[Solution],
    pack: Pack,
    symmetry: Symmetry = NO_SYMMETRY,
) -> tuple[WarmStart, ...]:
    """One warm start a gait that is the `label` of a grid task, sorted by gait.

    A gait's region is the grid tasks with that label. A gait may have several patterns; the one that is best
    at most tasks of the region is taken (of equal ones the first as text), and its solutions at all tasks of the region
    are averaged. `pack(trajectory, cycle_duration, pattern)` gives the scaled decision vector [nw]. Solutions without
    trajectory or multipliers are left out, and so are those of a pattern that is another gait elsewhere in the map, by
    the `symmetry` that all of its tasks have. Raises ValueError naming a gait that has none left.
    """
    grid = labels[(labels["split"] != "held_out") & (labels["status"] == "solved")]
    key_of = dict(zip(grid["gait"], grid["gait_key"], strict=True))
    *axes, _ = task_columns(labels.columns)
    places = grid[axes].itertuples(index=False, name=None)
    region = {place: (str(gait), key_of[gait]) for place, gait in zip(places, grid["label"], strict=True)}
    by_gait: dict[str, dict[TaskKey, list[Solution]]] = {gait: {} for gait, _ in region.values()}
    for solution in solutions:
        task = solution.task.on(axes)
        gait, key = region.get(task, ("", ""))
        if solution.task.split == "held_out" or solution.gait != key or not _usable(solution):
            continue
        if gait_of(Pattern.from_text(solution.pattern), symmetry).text == key:
            by_gait[gait].setdefault(task, []).append(solution)
    return tuple(_mean(gait, by_gait[gait], pack) for gait in sorted(by_gait))


def _usable(solution: Solution) -> bool:
    kept = solution.trajectory is not None and solution.multipliers is not None
    return kept and solution.status == "solved" and solution.violation <= MAX_VIOLATION


def _mean(gait: str, region: dict[TaskKey, list[Solution]], pack: Pack) -> WarmStart:
    if not region:
        raise ValueError(
            f"gait {gait!r}: no solution of its region holds a trajectory with multipliers, so there is nothing to "
            "average; solve its tasks again"
        )
    best = Counter(min(found, key=lambda one: (one.cost, one.pattern)).pattern for found in region.values())
    pattern = min(best, key=lambda text: (-best[text], text))
    # Of several solves of one pattern at a task, the cheapest speaks for it.
    chosen = [
        min(same, key=lambda one: one.cost)
        for _, found in sorted(region.items())
        if (same := [one for one in found if one.pattern == pattern])
    ]
    trajectories = [(one.trajectory, one.task.cycle_duration) for one in chosen if one.trajectory is not None]
    multipliers = [one.multipliers for one in chosen if one.multipliers is not None]
    return WarmStart(
        gait=gait,
        pattern=pattern,
        tasks=len(chosen),
        primal=np.mean([pack(trajectory, duration, pattern) for trajectory, duration in trajectories], axis=0),
        bounds=np.mean([one.bounds for one in multipliers], axis=0),
        rows=np.mean([one.rows for one in multipliers], axis=0),
    )
