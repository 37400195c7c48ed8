"""The data of the report's interactive map: its slices, its tasks, what came second there, and the winners' motions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.task_space import TaskSpace
from gaitflow.report import axis_text
from gaitflow.report.animation import motion_data, robot_data
from gaitflow.report.decisions import Select
from gaitflow.report.gait_map import map_colours
from gaitflow.report.map_tasks import map_task_words, of_map
from gaitflow.report.palette import lighter
from gaitflow.report.region_paths import region_paths
from gaitflow.report.scene import scene_of
from gaitflow.report.slices import Slices, nearest_slices, slices_of
from gaitflow.report.tables import number
from gaitflow.report.task_facts import rivals, task_facts
from gaitflow.report.winners import by_size, winning_motions
from gaitflow.search.solution import Solution

DIGITS = 4  # of lengths, angles and forces over weight: a tenth of a millimetre is less than a pixel
DECISIONS = 45_000  # of the map that are drawn in all slices, as many as on the picture
RESOLUTION = 120  # decisions drawn along each axis of a slice, at most
MAX_SLICES = 225  # beyond them too few decisions are left for each


def interactive_map(
    labels: pd.DataFrame,
    solutions: Sequence[Solution],
    scenario: Scenario,
    gaits: Sequence[str],
    select: Select | None,
) -> dict[str, Any]:
    """What interactive_map.js draws, as plain data; the parameters are those of `write_report`.

    A task beside the slices stands in the nearest one; held-out tasks of a grid are marked where they do. Raises
    ValueError when `labels` is empty, a motion is not finite, or `select` answers with an index that is no gait.
    """
    space = scenario.tasks.space
    slices = slices_of(labels, scenario.tasks, MAX_SLICES)
    order = by_size(labels, gaits)
    colours = map_colours(order)
    motions = winning_motions(labels, solutions, space)
    scenes = {row: scene_of(motion, scenario) for row, motion in motions.items()}
    facts = task_facts(labels, space, gaits, select)
    dearer = rivals(labels, solutions, scenario)
    drawn_in = nearest_slices(labels, slices.further)
    tasks = []
    for at, (row, label) in enumerate(zip(labels.index, labels.to_dict("records"), strict=True)):
        between = bool(drawn_in.beside[at]) and not slices.nearest
        task = _task(label, slices, int(drawn_in.place[at]), between, colours, space)
        told, motion = facts[row], None
        if row in scenes:
            motion = motion_data(scenes[row], task["colour"], DIGITS)
            told = [*told, ("phases", " + ".join(map(number, scenes[row].durations)) + " s")]
        tasks.append(task | {"facts": told, "rivals": dearer.get(row, []), "motion": motion})
    won = labels.loc[labels["status"] == "solved", "gait"].value_counts()
    return {
        "start": _start(labels, slices, order[0]) if len(won) else 0,
        "axes": [
            {"label": axis_text.label(axis), "low": low, "high": high} for axis, (low, high) in slices.limits.items()
        ],
        "sliders": [
            {"label": axis_text.words(axis), "values": [axis_text.quantity(axis, value) for value in values]}
            for axis, values in slices.further.items()
        ],
        "slices": _slices(slices, gaits, select, colours),
        "tasks": tasks,
        "marks": _marks(tasks, slices, map_task_words(labels)),
        "gaits": [{"name": name, "colour": colours[name], "tasks": int(won.get(name, 0))} for name in order],
        "robot": robot_data(next(iter(scenes.values())), scenario) if scenes else None,
    }


def _task(
    label: Mapping[Any, Any], slices: Slices, place: int, between: bool, colours: Mapping[str, str], space: TaskSpace
) -> dict[str, Any]:
    """Where a task stands, in which slice or between them, and how it is drawn."""
    found = label["status"] == "solved"
    return {
        "x": float(label[slices.x]),
        "y": 0.0 if slices.y is None else float(label[slices.y]),
        "slice": place,
        "between": between,
        "held_out": label["split"] == "held_out",
        "found": found,
        "tied": len(label["ties"]) > 1,
        "gait": label["gait"] if found else "",
        "colour": colours[label["gait"]] if found else "",
        "title": axis_text.values(label, space.columns),
    }


def _start(labels: pd.DataFrame, slices: Slices, gait: str) -> int:
    """Which task is shown first: of the map's tasks with the gait the one nearest their middle, or the first of all."""
    rows = np.flatnonzero((labels["gait"] == gait) & of_map(labels))
    if not len(rows):
        return 0
    tasks = labels.iloc[rows][[*slices.limits, *slices.further]].to_numpy(dtype=float)
    spread = np.maximum(np.ptp(tasks, axis=0), 1e-9)
    return int(rows[np.argmin(np.linalg.norm((tasks - tasks.mean(axis=0)) / spread, axis=1))])


def _marks(tasks: Sequence[Mapping[str, Any]], slices: Slices, map_task: str) -> list[str]:
    """What tasks are drawn as, in words: of those that there are."""
    found = [task for task in tasks if task["found"]]
    marks = (
        (f"circles are {map_task}s", any(not task["held_out"] for task in found)),
        ("ringed where gaits tie", any(task["tied"] and not task["held_out"] for task in tasks)),
        ("diamonds held-out tasks", any(task["held_out"] for task in found)),
        ("open where they lie between slices, in the nearest one", any(task["between"] for task in found)),
        ("crosses tasks without a gait", len(found) < len(tasks)),
        ("each in the slice nearest to it", slices.nearest),
    )
    return [text for text, drawn in marks if drawn]


def _slices(
    slices: Slices, gaits: Sequence[str], select: Select | None, colours: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Of each slice its place on the sliders, and its regions as (colour, path) over `resolution` cells each way."""
    resolution = min(RESOLUTION, math.isqrt(DECISIONS // len(slices.panels)))
    found = []
    for panel in slices.panels:
        paths = {} if select is None else region_paths(select, slices.limits, panel.at, resolution, gaits)
        regions = [(lighter(colours[gait], 0.5), path) for gait, path in paths.items()]
        place = [slices.further[axis].index(value) for axis, value in panel.at.items()]
        found.append({"place": place, "resolution": resolution, "regions": regions})
    return found
