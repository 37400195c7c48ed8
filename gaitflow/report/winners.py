"""The solution behind each label: the trajectories that make up the region of a gait."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.dataset.read import Solutions
from gaitflow.report.palette import ordered_gaits
from gaitflow.search.solution import Solution

Key = tuple[object, ...]


def winners(labels: pd.DataFrame, solutions: Iterable[Solution], space: TaskSpace) -> dict[str, list[Solution]]:
    """Of each gait, in legend order, the best solutions of the tasks it wins, by the rising axes of `space.columns`.

    As `winning_motions` has them; a gait whose trajectories were not stored has an empty list.
    """
    motions = winning_motions(labels, solutions, space)
    solved = labels[labels["status"] == "solved"].sort_values(list(space.columns), kind="stable")
    regions: dict[str, list[Solution]] = {name: [] for name in ordered_gaits(solved["gait"])}
    for row, gait in solved["gait"].items():
        if row in motions:
            regions[gait].append(motions[row])
    return regions


def winning_motions(labels: pd.DataFrame, solutions: Iterable[Solution], space: TaskSpace) -> dict[Hashable, Solution]:
    """The solution behind each label, by the label's index; solutions without a trajectory are left out.

    A solution belongs to a label when task, split and pattern agree; of several the cheapest.
    """
    axes = space.columns
    solved = labels[labels["status"] == "solved"]
    if isinstance(solutions, Solutions):  # of a large dataset only a tenth or less has a pattern that wins
        solutions = solutions.solved(set(solved["pattern"]))
    best: dict[Key, Solution] = {}
    for solution in solutions:
        key = _key({axis: solution.task[axis] for axis in axes}, axes, solution.task.split, solution.pattern)
        usable = solution.status == "solved" and solution.trajectory is not None
        if usable and (key not in best or solution.cost < best[key].cost):
            best[key] = solution
    keys = [_key(row, axes, row["split"], row["pattern"]) for row in solved.to_dict("records")]
    return {row: best[key] for row, key in zip(solved.index, keys, strict=True) if key in best}


def by_size(labels: pd.DataFrame, gaits: Iterable[str] = ()) -> tuple[str, ...]:
    """The gaits that win a task, and `gaits`, by the number of tasks they win, most first; equal ones as in legends."""
    won = Counter(labels.loc[labels["status"] == "solved", "gait"])
    return tuple(sorted(ordered_gaits([*won, *gaits]), key=lambda name: -won[name]))


def _key(values: Mapping[Any, Any], axes: Sequence[str], split: object, pattern: object) -> Key:
    return (*(round(values[axis], 9) for axis in axes), split, pattern)


def counted(tasks: int) -> str:
    """ "1 task", "2 tasks"."""
    return f"{tasks} task" if tasks == 1 else f"{tasks} tasks"


def trajectory_of(solution: Solution) -> Trajectory:
    """The solution's trajectory. Raises ValueError when none was stored."""
    if solution.trajectory is None:
        raise ValueError(
            f"the solution at {solution.task.text()} has no trajectory to draw; pass solutions whose status is 'solved'"
        )
    return solution.trajectory


def most_common_pattern(region: Sequence[Solution]) -> list[Solution]:
    """The solutions of a region that share its most common pattern, so that their phases and knots correspond."""
    pattern = Counter(solution.pattern for solution in region).most_common(1)[0][0]
    return [solution for solution in region if solution.pattern == pattern]


def mean_phase_fractions(region: Sequence[Solution]) -> Array:
    """Mean phase durations as fractions of the cycle [phases], over solutions of one pattern."""
    durations = np.array([trajectory_of(solution).durations for solution in region])
    return np.asarray((durations / durations.sum(axis=1, keepdims=True)).mean(axis=0))


def central(region: Sequence[Solution]) -> Solution:
    """The solution whose task lies nearest the middle of the region, each axis scaled to its spread."""
    tasks = np.array([solution.task.parameters for solution in region])
    spread = np.maximum(np.ptp(tasks, axis=0), 1e-9)
    return region[int(np.argmin(np.linalg.norm((tasks - tasks.mean(axis=0)) / spread, axis=1)))]
