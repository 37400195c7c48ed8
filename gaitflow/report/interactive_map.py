"""The data of the report's interactive map: its slices, its tasks, what came second there, and the winners' motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.core.task_space import TaskSpace
from gaitflow.report import axis_text
from gaitflow.report.animation import motion_data, robot_data
from gaitflow.report.gait_map import map_colours
from gaitflow.report.map_panel import Select
from gaitflow.report.palette import lighter
from gaitflow.report.region_paths import region_paths
from gaitflow.report.scene import scene_of
from gaitflow.report.slices import Slices, slices_of
from gaitflow.report.tables import number
from gaitflow.report.task_facts import rivals, task_facts
from gaitflow.report.winners import by_size, winning_motions
from gaitflow.search.solution import Solution

DIGITS = 4  # of lengths, angles and forces over weight: a tenth of a millimetre is less than a pixel
DECISIONS = 45_000  # of the map that are drawn in all slices, as many as on the picture
RESOLUTION = 120  # decisions drawn along each axis of a slice, at most

# What a task is drawn as, and which tasks are.
MARKS: Mapping[str, Callable[[Mapping[str, Any]], bool]] = {
    "circles are grid tasks": lambda task: task["grid"] and task["found"],
    "ringed where gaits tie": lambda task: task["grid"] and task["tied"],
    "diamonds held-out tasks": lambda task: not task["grid"] and task["found"],
    "open where they lie between slices, in the nearest one": lambda task: task["between"] and task["found"],
    "crosses tasks without a gait": lambda task: not task["found"],
}


def interactive_map(
    labels: pd.DataFrame,
    solutions: Sequence[Solution],
    scenario: Scenario,
    gaits: Sequence[str],
    select: Select | None,
) -> dict[str, Any]:
    """What interactive_map.js draws, as plain data; the parameters are those of `write_report`.

    A held-out task between the slices stands in the nearest one, marked as such. Raises ValueError when `labels` is
    empty, a motion is not finite, or `select` answers with an index that is no gait.
    """
    space = scenario.tasks.space
    slices = slices_of(labels, space, most=None)
    order = by_size(labels, gaits)
    colours = map_colours(order)
    motions = winning_motions(labels, solutions, space)
    scenes = {row: scene_of(motion, scenario) for row, motion in motions.items()}
    facts = task_facts(labels, space, gaits, select)
    dearer = rivals(labels, solutions, scenario)
    drawn_in = _slice_of_row(labels, slices)
    tasks = []
    for row, label in zip(labels.index, labels.to_dict("records"), strict=True):
        task = _task(label, slices, *drawn_in[row], colours, space)
        told, motion = facts[row], None
        if row in scenes:
            motion = motion_data(scenes[row], task["colour"], DIGITS)
            told = [*told, ("phases", " + ".join(map(number, scenes[row].durations)) + " s")]
        tasks.append(task | {"facts": told, "rivals": dearer.get(row, []), "motion": motion})
    won = labels.loc[labels["status"] == "solved", "gait"].value_counts()
    return {
        "start": _start(labels, slices, order[0]) if len(won) else 0,
        "axes": [
            {"label": axis_text.label(axis), "low": float(labels[axis].min()), "high": float(labels[axis].max())}
            for axis in (slices.x, slices.y)
            if axis is not None
        ],
        "sliders": [
            {"label": axis_text.words(axis), "values": [axis_text.quantity(axis, value) for value in values]}
            for axis, values in _further(slices).items()
        ],
        "slices": _slices(labels, slices, gaits, select, colours),
        "tasks": tasks,
        "marks": [text for text, drawn in MARKS.items() if any(map(drawn, tasks))],
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
        "grid": label["split"] == "grid",
        "found": found,
        "tied": len(label["ties"]) > 1,
        "gait": label["gait"] if found else "",
        "colour": colours[label["gait"]] if found else "",
        "title": axis_text.values(label, space.columns),
    }


def _start(labels: pd.DataFrame, slices: Slices, gait: str) -> int:
    """Which task is shown first: of the gait's grid tasks the one nearest their middle, or else the first of all."""
    rows = np.flatnonzero((labels["gait"] == gait) & (labels["split"] == "grid"))
    if not len(rows):
        return 0
    tasks = labels.iloc[rows][[slices.x, *([slices.y] if slices.y else []), *slices.panels[0].at]].to_numpy(dtype=float)
    spread = np.maximum(np.ptp(tasks, axis=0), 1e-9)
    return int(rows[np.argmin(np.linalg.norm((tasks - tasks.mean(axis=0)) / spread, axis=1))])


def _further(slices: Slices) -> dict[str, list[float]]:
    """The values of the further axes, rising."""
    axes = list(slices.panels[0].at)
    return {axis: sorted({panel.at[axis] for panel in slices.panels}) for axis in axes}


def _slices(
    labels: pd.DataFrame, slices: Slices, gaits: Sequence[str], select: Select | None, colours: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Of each slice its place on the sliders, and its regions as (colour, path) over `resolution` cells each way."""
    limits = {
        axis: (float(labels[axis].min()), float(labels[axis].max()))
        for axis in (slices.x, slices.y)
        if axis is not None
    }
    resolution = min(RESOLUTION, math.isqrt(DECISIONS // len(slices.panels)))
    further = _further(slices)
    found = []
    for panel in slices.panels:
        paths = {} if select is None else region_paths(select, limits, panel.at, resolution, gaits)
        regions = [(lighter(colours[gait], 0.5), path) for gait, path in paths.items()]
        place = [further[axis].index(value) for axis, value in panel.at.items()]
        found.append({"place": place, "resolution": resolution, "regions": regions})
    return found


def _slice_of_row(labels: pd.DataFrame, slices: Slices) -> dict[Hashable, tuple[int, bool]]:
    """In which slice a task is drawn, by the label's index, and whether it lies between slices."""
    inside = {row: (place, False) for place, panel in enumerate(slices.panels) for row in panel.labels.index}
    axes = list(slices.panels[0].at)
    others = labels.loc[[row for row in labels.index if row not in inside]]
    if others.empty:
        return inside
    places = np.array([[panel.at[axis] for axis in axes] for panel in slices.panels])
    spread = np.maximum(np.ptp(places, axis=0), 1e-9)
    tasks = others[axes].to_numpy(dtype=float)
    away = np.linalg.norm((tasks[:, None] - places) / spread, axis=2)
    return inside | {row: (int(place), True) for row, place in zip(others.index, away.argmin(axis=1), strict=True)}
