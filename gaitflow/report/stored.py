"""Finding a motion in a dataset: the stored task nearest to the one asked for, and its gaits by cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset.labels import gait_costs
from gaitflow.dataset.read import Solutions, load_solutions
from gaitflow.report.map_tasks import of_map
from gaitflow.search.solution import Solution


@dataclass(frozen=True)
class Ranked:
    """A gait of a task; rank 1 costs least, or is what a map takes first.

    `row` is its cheapest solution's place in the dataset, -1 outside one.
    """

    rank: int
    gait: str
    pattern: str
    cost: float
    has_motion: bool
    row: int


@dataclass(frozen=True)
class Shown:
    """A task, its gaits by rank, and how the motion of one of them is had; `title` says what the task is.

    `first` is the gait whose motion is shown unless another one is asked for.
    """

    title: str
    scenario: Scenario
    task: Task
    ranked: tuple[Ranked, ...]
    motion: Callable[[Ranked], Solution]
    first: Callable[[], Ranked]


def of_dataset(folder: Path, values: Mapping[str, float]) -> Shown:
    """The stored task of a dataset nearest to `values`. Raises ValueError as `nearest_task` does."""
    solutions = load_solutions(folder)
    task = nearest_task(solutions, values)
    ranked = ranked_gaits(solutions, task)
    return Shown(
        title="nearest stored task",
        scenario=scenario_of(solutions),
        task=task,
        ranked=ranked,
        motion=lambda one: motion_of(solutions, one),
        first=lambda: chosen(ranked, None, None),
    )


def scenario_of(solutions: Solutions) -> Scenario:
    """The scenario that a dataset was solved for. Raises ValueError when its record holds none."""
    if "scenario" not in solutions.record:
        raise ValueError(f"the file is a {solutions.record['kind']}, which names no scenario; give a collected dataset")
    return Scenario.from_data(solutions.record["scenario"], "the dataset's scenario")


def nearest_task(solutions: Solutions, values: Mapping[str, float], held_out: bool = True) -> Task:
    """The solved task nearest to these values, each axis scaled to the range that the dataset spans on it.

    Held-out tasks are looked at unless `held_out` is false. Raises ValueError for values that are no task of the
    dataset's axes (see `TaskSpace.task`), and when nothing in the dataset is solved.
    """
    space = scenario_of(solutions).tasks.space
    asked = space.task(values)
    frame = solutions.frame()
    looked_at = (frame["status"] == "solved") & (of_map(frame) | held_out)
    tasks = frame.loc[looked_at, [*space.columns, "split"]].drop_duplicates()
    if tasks.empty:
        raise ValueError("no task of the dataset is solved, so there is no motion to show")
    places = tasks[list(space.columns)].to_numpy(dtype=float)
    spread = np.ptp(places, axis=0)
    spread[spread == 0] = 1.0  # an axis with one value tells no task from another
    away = np.linalg.norm((places - asked.on(space.columns)) / spread, axis=1)
    nearest = tasks.iloc[int(np.argmin(away))]
    return space.task({axis: float(nearest[axis]) for axis in space.columns}, nearest["split"])


def ranked_gaits(solutions: Solutions, task: Task) -> tuple[Ranked, ...]:
    """The feasible gaits of a task, the cheapest first."""
    scenario, frame = scenario_of(solutions), solutions.frame()
    here = [frame[axis] == task[axis] for axis in scenario.tasks.space.columns]
    of_task = frame[np.logical_and.reduce([*here, frame["split"] == task.split])]
    motions = ~np.asarray(solutions.table["base"].combine_chunks().is_null())
    costs = gait_costs(of_task, scenario.robot.leg_names)
    found = []
    for rank, best in enumerate(costs.to_dict("records"), start=1):
        row = _row(of_task, best["pattern"], best["cost"])
        found.append(Ranked(rank, best["gait"], best["pattern"], best["cost"], bool(motions[row]), row))
    return tuple(found)


def _row(of_task: pd.DataFrame, pattern: str, cost: float) -> int:
    return int(of_task.index[(of_task["pattern"] == pattern) & (of_task["cost"] == cost)][0])


def chosen(ranked: tuple[Ranked, ...], gait: str | None, rank: int | None) -> Ranked:
    """The gait of that name, or of that rank, or else the cheapest.

    Raises ValueError that lists the gaits when there is none such, or when its motion was not stored.
    """
    there = "; ".join(f"{one.rank} {one.gait}" for one in ranked if one.has_motion) or "none"
    asked = f"gait {gait!r}" if gait is not None else f"rank {rank or 1}"
    found = next((one for one in ranked if (one.gait == gait if gait is not None else one.rank == (rank or 1))), None)
    if found is None:
        raise ValueError(f"{asked}: not among the {len(ranked)} feasible gaits of this task; with a motion: {there}")
    if not found.has_motion:
        raise ValueError(f"{asked}: only its cost was stored, not its motion; with a motion: {there}")
    return found


def motion_of(solutions: Solutions, ranked: Ranked) -> Solution:
    """The stored solution of a ranked gait."""
    return solutions[ranked.row]
