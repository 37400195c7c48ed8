"""A sweep as a picture: for which share of robots each statement holds, and how it goes with each parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from gaitflow.report.sweep_shares import SURE, Share

COLOURS = ("#E69F00", "#0072B2")  # of the shares, a rule of motion
INK, PALE = "#222222", "#e4e4e4"
LINE = 0.27  # inches a statement


def draw_sweep(shares: Mapping[str, Mapping[str, Share]], title: str) -> Figure:
    """Left the share of robots with its interval; then a panel a rule with rank correlations, dots where p < SURE.

    `shares` has for each rule of motion, by its name, the share of each statement. Raises ValueError without any.
    """
    names = list(dict.fromkeys(name for found in shares.values() for name in found))
    if not names:
        raise ValueError("no statement was asked: there is nothing to draw")
    parameters = list(
        dict.fromkeys(key for found in shares.values() for one in found.values() for key in one.influences)
    )
    panels = len(shares) if parameters else 0  # nothing decides where all robots agree
    figure = Figure(figsize=(4.6 + 3.2 * panels, 2.4 + LINE * len(names)), dpi=150, layout="constrained")
    grid = figure.subplots(1, 1 + panels, squeeze=False, sharey=True, width_ratios=(1.0, *[0.9] * panels))
    left, *right = grid.flat
    _draw_shares(left, shares, names)
    for axes, (rule, found) in zip(right, shares.items(), strict=False):
        _draw_correlations(axes, found, names, parameters)
        axes.set_title(f"{rule}: rank correlation", fontsize=10, loc="left")
    if right:
        scale = ScalarMappable(cmap="RdBu_r")
        scale.set_clim(-1, 1)
        bar = figure.colorbar(scale, ax=right, shrink=0.5, pad=0.02)
        bar.set_label(f"holds for larger values (red), smaller (blue); dot: p < {SURE:g}", fontsize=8)
        bar.ax.tick_params(labelsize=8)
    figure.suptitle(title, fontsize=12, x=0.01, ha="left")
    return figure


def _draw_shares(axes: Axes, shares: Mapping[str, Mapping[str, Share]], names: Sequence[str]) -> None:
    height = 0.8 / len(shares)
    for number, (rule, found) in enumerate(shares.items()):
        for row, name in enumerate(names):
            if name not in found or not found[name].robots:
                continue
            one, y = found[name], row - 0.4 + height * (number + 0.5)
            partly = (one.holds + one.in_part) / one.robots
            axes.barh(y, partly, height, color=COLOURS[number], alpha=0.3, linewidth=0)
            axes.barh(y, one.holds / one.robots, height, color=COLOURS[number], linewidth=0, label="" if row else rule)
            axes.plot([one.low, one.high], [y, y], color=INK, linewidth=0.9)
    axes.set_yticks(range(len(names)), names, fontsize=9)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of robots (pale: in part; line: 95 %)", fontsize=9)
    axes.set_title("holds", fontsize=10, loc="left")
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles, labels, fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0.2, 1.0), ncols=2)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(axis="x", color=PALE, linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _draw_correlations(axes: Axes, found: Mapping[str, Share], names: Sequence[str], parameters: Sequence[str]) -> None:
    values = np.full((len(names), len(parameters)), np.nan)
    for row, name in enumerate(names):
        for column, parameter in enumerate(parameters):
            influence = found[name].influences.get(parameter) if name in found else None
            if influence is None:
                continue
            values[row, column] = influence.correlation
            if influence.p < SURE:
                axes.plot(column, row, "o", color=INK, markersize=3.5)
    axes.imshow(values, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto")
    axes.set_xticks(range(len(parameters)), parameters, rotation=60, ha="right", rotation_mode="anchor", fontsize=8)
    axes.set_facecolor(PALE)
    axes.tick_params(axis="y", length=0)
