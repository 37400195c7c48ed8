"""The gait map in the manner of Fig. 4: decision regions and the tasks they were learnt from, slice by slice."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from matplotlib.typing import MarkerType

from gaitflow.config.axes import Tasks
from gaitflow.report import axis_text
from gaitflow.report.decisions import Select
from gaitflow.report.map_panel import INK, Panel, draw_regions, draw_tasks
from gaitflow.report.map_tasks import map_task_words, of_map
from gaitflow.report.palette import gait_colours, kind_and_contacts
from gaitflow.report.slices import Slices, slices_of
from gaitflow.report.winners import by_size

RESOLUTION = 210  # decisions drawn along each axis of a map of one panel; of several, as many in all
LONG_NAME = 22  # letters
MAX_NAMED = 12  # gaits with a colour of their own, those that win most tasks
COLUMNS = 3  # of panels that are no matrix
TAIL = "#c4c4c4"
TITLE_WIDTH, BESIDE_LEGEND = 90, 68  # characters of a line over the whole figure, and beside a legend
BAND = (-0.5, 0.5)  # heights of a map of one axis


def draw_gait_map(
    labels: pd.DataFrame, gaits: Sequence[str], select: Select | None, title: str, tasks: Tasks
) -> Figure:
    """Regions by `select`, whose indices point into `gaits`; tasks by their best gait; a panel a slice of the map.

    `tasks` are the scenario's axes. The map's tasks are filled circles, ringed where gaits tie; held-out tasks
    diamonds; tasks without a gait crosses. Panels over two further axes are a matrix, one axis a row, the other a
    column. Without `select` (no classifier was trained) only the tasks are drawn. The legend begins with the gait that
    wins most tasks; beyond MAX_NAMED gaits the others share one grey. Gaits whose names end with their contacts are
    numbered, and so are their regions. Raises ValueError when `labels` is empty or `select` answers with an index that
    is no gait.
    """
    slices = slices_of(labels, tasks)
    order = by_size(labels, gaits)
    colours = map_colours(order)
    named = [name for name in order if colours[name] != TAIL]
    numbered = any(kind_and_contacts(name)[1] for name in named)
    short = {name: str(i) if numbered else name for i, name in enumerate(named, start=1)}
    entries = {f"{i}   {name}" if numbered else name: colours[name] for i, name in enumerate(named, start=1)}
    if len(named) < len(order):
        entries[f"{len(order) - len(named)} other gaits"] = TAIL
    handles = _legend(pd.concat([panel.labels for panel in slices.panels]), entries, map_task_words(labels))
    # Names with contacts and diagrams are too long to stand beside the map.
    below = len(slices.panels) > 1 or max(len(str(handle.get_label())) for handle in handles) > LONG_NAME
    figure, panels = _panels(slices, math.ceil(len(handles) / 2) if below else 0)
    limits = [slices.limits[axis] if axis else BAND for axis in (slices.x, slices.y)]
    resolution = round(RESOLUTION / math.sqrt(len(panels)))
    for panel in panels:
        if select is not None:
            draw_regions(panel, limits, resolution, gaits, select, colours, short)
        draw_tasks(panel, colours)
        panel.axes.use_sticky_edges = False
        panel.axes.margins(0.035)
    figure.suptitle(textwrap.fill(title, TITLE_WIDTH if below else BESIDE_LEGEND), fontsize=12, x=0.01, ha="left")
    if below:
        figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    else:
        figure.legend(handles=handles, loc="outside right upper", fontsize=10, frameon=False)
    return figure


def map_colours(order: Sequence[str]) -> dict[str, str]:
    """Hex colour of each gait on a map: its own, and one grey beyond the first MAX_NAMED, unless that is one gait."""
    own = gait_colours(order)
    named = order if len(order) <= MAX_NAMED + 1 else order[:MAX_NAMED]
    return {name: own[name] if name in named else TAIL for name in order}


def _panels(slices: Slices, legend_lines: int) -> tuple[Figure, list[Panel]]:
    """A figure with axes for every slice, without anything in them; the legend has so many lines below."""
    several = [axis for axis, values in slices.further.items() if len(values) > 1]
    down = several[0] if len(several) == 2 else None  # the axis of a matrix' rows
    columns = len(slices.further[several[1]]) if down else min(len(slices.panels), COLUMNS)
    rows = math.ceil(len(slices.panels) / columns)
    height = 2.0 if slices.y is None else 5.0 if columns == 1 else 2.6
    figure = Figure(figsize=(8.4, rows * height + 0.21 * legend_lines + 0.3 * (columns > 1)), dpi=150)
    figure.set_layout_engine("constrained")
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    scale = 1.0 if columns == 1 else 0.62
    panels = []
    for place, axes in enumerate(grid.flat):
        if place >= len(slices.panels):
            axes.set_axis_off()
            continue
        one = slices.panels[place]
        last = place + columns >= len(slices.panels)
        _label_axes(axes, slices, last, place % columns == 0, columns)
        if down:
            _head_matrix(axes, one.at, down, place < columns, place % columns == columns - 1)
        elif one.at:
            axes.set_title(axis_text.values(one.at, one.at), fontsize=9, loc="left")
        panels.append(Panel(axes, slices.x, slices.y, one.labels, one.at, scale))
    return figure, panels


def _head_matrix(axes: Axes, at: Mapping[str, float], down: str, top: bool, right: bool) -> None:
    """The values of a matrix' columns above its first row, those of its rows, on the axis `down`, beside its last."""
    if top:
        axes.set_title(axis_text.values_in_words(at, (axis for axis in at if axis != down)), fontsize=9, loc="left")
    if right:
        axes.annotate(
            axis_text.values_in_words(at, [down]), (1.05, 0.5), xycoords="axes fraction", rotation=270, fontsize=9,
            ha="left", va="center",
        )  # fmt: skip


def _label_axes(axes: Axes, slices: Slices, below: bool, left: bool, columns: int) -> None:
    size = 12 if columns == 1 else 9
    if below:
        axes.set_xlabel(axis_text.label(slices.x), fontsize=size)
        axes.tick_params(labelbottom=True)
    if left and slices.y is not None:
        axes.set_ylabel(axis_text.label(slices.y), fontsize=size)
    axes.tick_params(labelsize=size - 1)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(12 if columns == 1 else 6, steps=[1, 2, 5, 10]))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if slices.y is None:
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)


def _legend(labels: pd.DataFrame, entries: Mapping[str, str], map_task: str) -> list[Patch | Line2D]:
    solved = labels["status"] == "solved"
    of_the_map, ties = of_map(labels), labels["ties"].map(len) > 1
    kinds: tuple[tuple[str, MarkerType, int, str, bool], ...] = (
        (map_task, "o", 7, "white", bool((solved & of_the_map).any())),
        ("held-out task", "D", 5, "white", bool((solved & ~of_the_map).any())),
        ("gaits tie", "o", 12, "none", bool((ties & of_the_map).any())),
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
