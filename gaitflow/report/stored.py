"""Finding a motion in a dataset: the stored task nearest to the one asked for, and its gaits by cost."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset.labels import TASK, gait_costs
from gaitflow.dataset.read import Solutions
from gaitflow.search.solution import Solution


@dataclass(frozen=True)
class Ranked:
    """A gait of a task; rank 1 costs least. `row` is its cheapest solution's place in the dataset."""

    rank: int
    gait: str
    pattern: str
    cost: float
    has_motion: bool
    row: int


def scenario_of(solutions: Solutions) -> Scenario:
    """The scenario that a dataset was solved for. Raises ValueError when its record holds none."""
    if "scenario" not in solutions.record:
        raise ValueError(f"the file is a {solutions.record['kind']}, which names no scenario; give a collected dataset")
    return Scenario.from_data(solutions.record["scenario"], "the dataset's scenario")


def nearest_task(solutions: Solutions, speed: float, cycle_duration: float) -> Task:
    """The solved task nearest to (speed [m/s], cycle_duration [s]), each scaled to the range that the dataset spans.

    Raises ValueError when the numbers are not finite or nothing in the dataset is solved.
    """
    if not (math.isfinite(speed) and math.isfinite(cycle_duration)):
        raise ValueError(f"speed {speed:g} m/s, cycle {cycle_duration:g} s: both must be finite")
    frame = solutions.frame()
    tasks = frame.loc[frame["status"] == "solved", TASK].drop_duplicates()
    if tasks.empty:
        raise ValueError("no task of the dataset is solved, so there is no motion to show")
    values = tasks[["speed", "cycle_duration"]].to_numpy(dtype=float)
    spread = np.ptp(values, axis=0)
    spread[spread == 0] = 1.0  # an axis with one value tells no task from another
    nearest = tasks.iloc[int(np.argmin(np.linalg.norm((values - [speed, cycle_duration]) / spread, axis=1)))]
    return Task(float(nearest["speed"]), float(nearest["cycle_duration"]), nearest["split"])


def ranked_gaits(solutions: Solutions, task: Task) -> tuple[Ranked, ...]:
    """The feasible gaits of a task, the cheapest first."""
    frame = solutions.frame()
    here = np.logical_and.reduce([frame[name] == getattr(task, name) for name in TASK])
    of_task = frame[here]
    motions = ~np.asarray(solutions.table["base"].combine_chunks().is_null())
    costs = gait_costs(of_task, scenario_of(solutions).robot.leg_names)
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
