"""Two maps of the same tasks beside each other: forward Euler's and that of the exact motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.task_space import TaskSpace
from gaitflow.report import axis_text
from gaitflow.report.map_panel import INK, Panel, draw_tasks
from gaitflow.report.palette import gait_colours, ordered_gaits
from gaitflow.report.slices import main_axes

DECIMALS = 9  # of a task's values, as grids are rounded
CHANGED = "#C1121F"


@dataclass(frozen=True)
class LabelledMap:
    """A map's scenario, its labels, and the least cost of every gait at every task (`gaitflow.dataset.labels`)."""

    scenario: Scenario
    labels: pd.DataFrame
    costs: pd.DataFrame


def compare(euler: LabelledMap, exact: LabelledMap) -> pd.DataFrame:
    """The labels of the tasks that both maps solved, a row a task.

    Columns: the axes and split, `euler` and `exact` (names of the gaits), `changed` (whether they are different gaits
    to the exact map, which may merge a gait with its time reversal), `excess`: how much dearer Euler's gait is by the
    exact map's costs, as a share; NaN where it has no motion there.
    """
    space = exact.scenario.tasks.space
    key = [*space.columns, "split"]
    frames = [_rounded(each.labels[each.labels["status"] == "solved"], space) for each in (euler, exact)]
    both = frames[0][[*key, "gait", "gait_key"]].merge(
        frames[1][[*key, "gait", "gait_key"]], on=key, suffixes=("_euler", "_exact")
    )
    best = [_exact_gait(exact.scenario, row, space) for row in both.to_dict("records")]
    costs = _rounded(exact.costs, space)
    excess = dict(zip(map(tuple, costs[[*key, "gait_key"]].to_numpy().tolist()), _excess(costs, key), strict=True))
    places = both[key].to_numpy().tolist()
    return both[key].assign(
        euler=both["gait_euler"],
        exact=both["gait_exact"],
        changed=np.array(best) != both["gait_key_exact"].to_numpy(),
        excess=[excess.get((*place, gait), np.nan) for place, gait in zip(places, best, strict=True)],
    )


def _rounded(frame: pd.DataFrame, space: TaskSpace) -> pd.DataFrame:
    return frame.assign(**{axis: frame[axis].round(DECIMALS) for axis in space.columns})


def _exact_gait(scenario: Scenario, row: Mapping[Any, Any], space: TaskSpace) -> str:
    """What Euler's gait is called by the exact map: one of a pair that time reversal joins may stand for both."""
    task = space.task({axis: row[axis] for axis in space.columns})
    return gait_of(Pattern.from_text(row["gait_key_euler"]), scenario.symmetry(task)).text


def _excess(costs: pd.DataFrame, key: list[str]) -> list[float]:
    if "excess" in costs.columns:  # of refined costs, where there are any
        return [float(each) for each in costs["excess"]]
    best = costs.groupby(key)["cost"].transform("min")
    return [float(each) for each in costs["cost"] / best - 1]


def draw_side_by_side(euler: LabelledMap, exact: LabelledMap, title: str) -> Figure:
    """Euler's map on the left, the exact one on the right; framed are tasks whose label changed.

    For maps of two axes. Raises ValueError for maps of more or fewer.
    """
    space = exact.scenario.tasks.space
    x, y = main_axes(space)
    if y is None or len(space.ranged) != 2:
        raise ValueError(f"{exact.scenario.name}: {len(space.ranged)} axes; two maps stand side by side over two")
    found = compare(euler, exact)
    changed = found[found["changed"]]
    names = ordered_gaits(
        name for each in (euler, exact) for name in each.labels.loc[each.labels["status"] == "solved", "gait"]
    )
    colours = gait_colours(names)
    lines = -(-(len(names) + 2) // 3)
    figure = Figure(figsize=(10.4, 4.4 + 0.21 * lines), dpi=150, layout="constrained")
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for each, one, heading in zip((euler, exact), axes, ("forward Euler", "exact motion"), strict=True):
        panel = Panel(one, x, y, each.labels, {}, 0.9)
        draw_tasks(panel, colours)
        frame: dict[str, Any] = {
            "marker": "s",
            "s": 150,
            "facecolors": "none",
            "edgecolors": CHANGED,
            "linewidths": 1.6,
        }
        one.scatter(changed[x], changed[y], zorder=4, clip_on=False, **frame)
        one.set_title(heading, fontsize=11, loc="left")
        one.set_xlabel(axis_text.label(x), fontsize=11)
        for side in ("top", "right"):
            one.spines[side].set_visible(False)
    axes[0].set_ylabel(axis_text.label(y), fontsize=11)
    handles: list[Patch | Line2D] = [Patch(facecolor=colours[name], label=name) for name in names]
    ties = any((each.labels["ties"].map(len) > 1).any() for each in (euler, exact))
    marks = [("label changed", "s", CHANGED, 10)] + [("gaits tie", "o", INK, 11)] * ties
    for told, marker, colour, size in marks:
        line = Line2D([], [], linestyle="", marker=marker, color=colour, markersize=size, markerfacecolor="none")
        line.set_label(told)
        handles.append(line)
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=9, frameon=False)
    figure.suptitle(f"{title}: {len(changed)} of {len(found)} labels changed", fontsize=12, x=0.01, ha="left")
    return figure
