"""One panel of a gait map: the regions that a classifier or atlas decides for, and the tasks as they were solved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from scipy import ndimage

from gaitflow.report.decisions import Floats, Select, decisions
from gaitflow.report.map_tasks import of_map
from gaitflow.report.palette import lighter

Mask = NDArray[np.bool_]

TEXT_HEIGHT, TEXT_WIDTH = 0.05, 0.016  # of a name inside its region, a letter: share of the axes
INK = "#222222"


@dataclass(frozen=True)
class Panel:
    """What a panel shows on which axes: y None for a map of one axis, whose tasks stand in a row.

    labels: its tasks. at: the values of the further axes. scale: how large text and markers are, 1 in a panel that
    fills a figure.
    """

    axes: Axes
    x: str
    y: str | None
    labels: pd.DataFrame
    at: Mapping[str, float]
    scale: float = 1.0

    def places(self, tasks: pd.DataFrame) -> tuple[Floats, Floats]:
        """Where tasks are drawn, along x and y [n]."""
        x = tasks[self.x].to_numpy(dtype=float)
        return x, np.zeros(len(x)) if self.y is None else tasks[self.y].to_numpy(dtype=float)


def draw_regions(
    panel: Panel,
    limits: Sequence[tuple[float, float]],
    resolution: int,
    gaits: Sequence[str],
    select: Select,
    colours: Mapping[str, str],
    short: Mapping[str, str],
) -> None:
    """Fill the box `limits`, (low, high) of x and y, with the gaits chosen there; `short` names gaits in the picture.

    Raises ValueError when `select` answers with an index that is no gait.
    """
    rows = resolution if panel.y is not None else 60  # of a strip, all alike
    x, y = (np.linspace(*limit, count) for limit, count in zip(limits, (resolution, rows), strict=True))
    along = {panel.x: x} if panel.y is None else {panel.x: x, panel.y: y}
    chosen = np.broadcast_to(decisions(select, along, panel.at, len(gaits)), (rows, resolution))
    panel.axes.pcolormesh(
        x, y, np.ma.masked_less(chosen, 0),
        cmap=ListedColormap([lighter(colours[name], 0.5) for name in gaits]),
        vmin=-0.5, vmax=len(gaits) - 0.5, shading="nearest", rasterized=True,
    )  # fmt: skip
    _draw_borders(panel, x, y, chosen, gaits, short)


def _draw_borders(
    panel: Panel, x: Floats, y: Floats, chosen: NDArray[Any], gaits: Sequence[str], short: Mapping[str, str]
) -> None:
    occupied = np.zeros(chosen.shape, dtype=bool)
    columns, rows = (
        np.abs(along - places[:, None]).argmin(axis=1)
        for along, places in zip((x, y), panel.places(panel.labels), strict=True)
    )
    occupied[rows, columns] = True
    for index in np.unique(chosen[chosen >= 0]):
        inside = chosen == index
        if not inside.all():
            panel.axes.contour(x, y, inside.astype(float), levels=[0.5], colors="white", linewidths=1.5 * panel.scale)
        if panel.y is not None:
            _name_region(panel, x, y, inside, occupied, short.get(gaits[index], ""))


def _name_region(panel: Panel, x: Floats, y: Floats, inside: Mask, occupied: Mask, name: str) -> None:
    """Write a short name where its region is widest and free of tasks, if it fits there."""
    if "/" in name or not name:
        return
    cells = len(x)
    # Of a cell, in sizes of the text.
    size = (panel.scale**2 / cells / TEXT_HEIGHT, panel.scale**2 / cells / (TEXT_WIDTH * len(name)))
    edge = ndimage.distance_transform_edt(np.pad(inside, 1), sampling=size)[1:-1, 1:-1]
    room = edge
    if occupied.any():
        task = ndimage.distance_transform_edt(~occupied, sampling=size)
        room = np.minimum(edge, task) + 0.1 * task
    row, column = np.unravel_index(int(np.argmax(room)), room.shape)
    if edge[row, column] < 0.5:
        return
    text = panel.axes.text(
        x[column], y[row], name, ha="center", va="center", fontsize=max(11 * panel.scale, 7), color=INK, zorder=5
    )
    text.set_path_effects([withStroke(linewidth=3 * panel.scale, foreground="white")])


def draw_tasks(panel: Panel, colours: Mapping[str, str]) -> None:
    """The map's tasks as filled circles, ringed where gaits tie; held-out ones as diamonds; crosses have no gait."""
    labels, scale = panel.labels, panel.scale**2
    solved = labels[labels["status"] == "solved"]
    of_the_map = of_map(solved)
    common: dict[str, Any] = {"zorder": 3, "clip_on": False}
    for drawn, marker, size in ((of_the_map, "o", 46), (~of_the_map, "D", 20)):
        tasks = solved[drawn]
        panel.axes.scatter(
            *panel.places(tasks), s=size * scale, c=[colours[name] for name in tasks["gait"]], marker=marker,
            edgecolors=INK, linewidths=0.6 * panel.scale, **common,
        )  # fmt: skip
    tied = solved[(solved["ties"].map(len) > 1) & of_the_map]
    missing = labels[labels["status"] != "solved"]
    panel.axes.scatter(*panel.places(tied), s=130 * scale, facecolors="none", edgecolors=INK, **common)
    panel.axes.scatter(*panel.places(missing), s=42 * scale, c=INK, marker="x", linewidths=1.4 * panel.scale, **common)
