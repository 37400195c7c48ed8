"""The gait map in the manner of Fig. 4: decision regions of the classifier and the tasks they were learnt from."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.typing import MarkerType
from numpy.typing import NDArray
from scipy import ndimage

from gaitflow.report.palette import gait_colours, kind_and_contacts, lighter
from gaitflow.report.winners import by_size

# (speeds [n] m/s, cycle durations [n] s) -> index [n] of the chosen gait, -1 outside the domain.
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Select = Callable[[Floats, Floats], NDArray[np.integer[Any]]]

RESOLUTION = 300  # decisions drawn along each axis
TEXT_HEIGHT, TEXT_WIDTH = 0.05, 0.016  # of a name inside its region, a letter: share of the axes
LONG_NAME = 22  # letters
MAX_NAMED = 12  # gaits with a colour of their own, those that win most tasks
INK, TAIL = "#222222", "#c4c4c4"


def draw_gait_map(labels: pd.DataFrame, gaits: Sequence[str], select: Select | None, title: str) -> Figure:
    """Speed on x, cycle duration on y: regions by `select`, whose indices point into `gaits`; tasks by their best gait.

    Grid tasks are filled circles, ringed where gaits tie; held-out tasks diamonds; tasks without a gait crosses.
    Without `select` (no classifier was trained) only the tasks are drawn. The legend begins with the gait that wins
    most tasks; beyond MAX_NAMED gaits the others share one grey. Gaits whose names end with their contacts are
    numbered, and so are their regions. Raises ValueError when `labels` is empty or `select` answers with an index
    that is no gait.
    """
    if labels.empty:
        raise ValueError("the labels have no task; solve the scenario first")
    order = by_size(labels, gaits)
    named = order if len(order) <= MAX_NAMED + 1 else order[:MAX_NAMED]
    own = gait_colours(order)
    colours = {name: own[name] if name in named else TAIL for name in order}
    numbered = any(kind_and_contacts(name)[1] for name in named)
    short = {name: str(i) if numbered else name for i, name in enumerate(named, start=1)}
    entries = {f"{i}   {name}" if numbered else name: colours[name] for i, name in enumerate(named, start=1)}
    if len(named) < len(order):
        entries[f"{len(order) - len(named)} other gaits"] = TAIL
    handles = _legend(labels, entries)
    # Names with contacts and diagrams are too long to stand beside the map.
    below = max(len(str(handle.get_label())) for handle in handles) > LONG_NAME
    lines = math.ceil(len(handles) / 2)
    figure = Figure(figsize=(8.4, 5.0 + 0.21 * lines * below), dpi=150, layout="constrained")
    axes = figure.add_subplot()
    if select is not None:
        _draw_regions(axes, labels, gaits, select, colours, short)
    _draw_tasks(axes, labels, colours)
    axes.set_xlabel("speed v [m/s]", fontsize=12)
    axes.set_ylabel("cycle duration T [s]", fontsize=12)
    axes.set_title(title, fontsize=12, loc="left")
    axes.tick_params(labelsize=11)
    axes.use_sticky_edges = False
    axes.margins(0.035)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(12, steps=[1, 2, 5, 10]))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if below:
        figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    else:
        figure.legend(handles=handles, loc="outside right upper", fontsize=10, frameon=False)
    return figure


def _draw_regions(
    axes: Axes,
    labels: pd.DataFrame,
    gaits: Sequence[str],
    select: Select,
    colours: Mapping[str, str],
    short: Mapping[str, str],
) -> None:
    limits = [(labels[axis].min(), labels[axis].max()) for axis in ("speed", "cycle_duration")]
    speeds, durations = (np.linspace(low, high, RESOLUTION) for low, high in limits)
    v, t = np.meshgrid(speeds, durations)
    chosen = np.asarray(select(v.ravel(), t.ravel())).reshape(v.shape)
    if chosen.min() < -1 or chosen.max() >= len(gaits):
        raise ValueError(
            f"select answered {chosen.min()} to {chosen.max()}, but the gaits are numbered 0 to {len(gaits) - 1} "
            "and -1 is outside the domain; "
            "pass the gaits in the order of the classifier's classes"
        )
    colour_map = ListedColormap([lighter(colours[name], 0.5) for name in gaits])
    axes.pcolormesh(
        speeds,
        durations,
        np.ma.masked_less(chosen, 0),
        cmap=colour_map,
        vmin=-0.5,
        vmax=len(gaits) - 0.5,
        shading="nearest",
        rasterized=True,
    )
    occupied = np.zeros(chosen.shape, dtype=bool)
    rows = np.abs(durations - labels["cycle_duration"].to_numpy()[:, None]).argmin(axis=1)
    occupied[rows, np.abs(speeds - labels["speed"].to_numpy()[:, None]).argmin(axis=1)] = True
    for index in np.unique(chosen[chosen >= 0]):
        inside = chosen == index
        if not inside.all():
            axes.contour(speeds, durations, inside.astype(float), levels=[0.5], colors="white", linewidths=1.5)
        _name_region(axes, speeds, durations, inside, occupied, short.get(gaits[index], ""))


def _name_region(axes: Axes, speeds: Floats, durations: Floats, inside: Mask, occupied: Mask, name: str) -> None:
    """Write a short name where its region is widest and free of tasks, if it fits there."""
    if "/" in name or not name:
        return
    size = (1 / RESOLUTION / TEXT_HEIGHT, 1 / RESOLUTION / (TEXT_WIDTH * len(name)))  # of a cell, in sizes of the text
    edge = ndimage.distance_transform_edt(np.pad(inside, 1), sampling=size)[1:-1, 1:-1]
    task = ndimage.distance_transform_edt(~occupied, sampling=size)
    room = np.minimum(edge, task) + 0.1 * task
    row, column = np.unravel_index(int(np.argmax(room)), room.shape)
    if edge[row, column] < 0.5:
        return
    text = axes.text(speeds[column], durations[row], name, ha="center", va="center", fontsize=11, color=INK, zorder=5)
    text.set_path_effects([withStroke(linewidth=3, foreground="white")])


def _draw_tasks(axes: Axes, labels: pd.DataFrame, colours: Mapping[str, str]) -> None:
    solved = labels[labels["status"] == "solved"]
    for split, marker, size in (("grid", "o", 46), ("held_out", "D", 20)):
        tasks = solved[solved["split"] == split]
        at = tasks["speed"].to_numpy(), tasks["cycle_duration"].to_numpy()
        fill = [colours[name] for name in tasks["gait"]]
        axes.scatter(*at, s=size, c=fill, marker=marker, edgecolors=INK, linewidths=0.6, zorder=3, clip_on=False)
    tied = solved[(solved["ties"].map(len) > 1) & (solved["split"] == "grid")]
    axes.scatter(
        tied["speed"], tied["cycle_duration"], s=130, facecolors="none", edgecolors=INK, zorder=3, clip_on=False
    )
    missing = labels[labels["status"] != "solved"]
    axes.scatter(
        missing["speed"], missing["cycle_duration"], s=42, c=INK, marker="x", linewidths=1.4, zorder=3, clip_on=False
    )


def _legend(labels: pd.DataFrame, entries: Mapping[str, str]) -> list[Patch | Line2D]:
    solved = labels["status"] == "solved"
    on_grid, ties = labels["split"] == "grid", labels["ties"].map(len) > 1
    kinds: tuple[tuple[str, MarkerType, int, str, bool], ...] = (
        ("grid task", "o", 7, "white", bool((solved & on_grid).any())),
        ("held-out task", "D", 5, "white", bool((solved & ~on_grid).any())),
        ("gaits tie", "o", 12, "none", bool((ties & on_grid).any())),
        ("no gait found", "x", 7, "none", bool((~solved).any())),
    )
    handles: list[Patch | Line2D] = [Patch(facecolor=colour, label=name) for name, colour in entries.items()]
    for name, marker, size, fill, found in kinds:
        if found:
            line = Line2D(
                [], [], linestyle="", color=INK, marker=marker, markersize=size, markerfacecolor=fill, label=name
            )
            handles.append(line)
    return handles
