"""How long planning from a map takes, and the paper's ways beside it: the picture of `gaitflow bench online`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

BINS = 60
INK, BAR, TARGET = "#222222", "#56B4E9", "#D55E00"
QUANTILES: dict[str, Literal["-", "--", "-.", ":"]] = {"p50": "-", "p95": "--", "p99": "-.", "max": ":"}
PARTS = ("select", "predict", "refine")
NAMES = {
    "plan": "plan()",
    "bounds_mean": "bounds form,\nmean warm start",
    "bounds_random": "bounds form,\nrandom start",
    "bigm_random": "big-M form,\nrandom start",
}
SPREAD = 0.16  # of a method's dots, up and down
NARROW = 2.0  # decades, up to which an axis has room for numbers between the powers of ten

Rows = Sequence[Mapping[str, Any]]


def draw_latency(document: Mapping[str, Any]) -> Figure:
    """Left: how many calls of plan took how long, and its parts; right: CPU times of plan and the paper's ways.

    `document` is that of bench `online`. Raises ValueError when it has no row.
    """
    rows, summary = document["rows"], document["summary"]
    if not rows:
        raise ValueError("the document has no task; run `gaitflow bench online` with at least one")
    figure = Figure(figsize=(10.4, 5.0), dpi=150, layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0), height_ratios=(2.6, 1.0))
    _draw_histogram(figure.add_subplot(grid[0, 0]), rows, summary)
    _draw_parts(figure.add_subplot(grid[1, 0]), rows)
    _draw_methods(figure.add_subplot(grid[:, 1]), [row["paper"] for row in rows if "paper" in row], summary)
    figure.suptitle(f"Planning from the map {document['scenario']}", fontsize=12, x=0.01, ha="left")
    return figure


def _draw_histogram(axes: Axes, rows: Rows, summary: Mapping[str, Any]) -> None:
    wall, cpu = (np.array([row[f"{clock}_ms"] for row in rows]) for clock in ("wall", "cpu"))
    targets = {name: summary["targets"][f"plan_ms_{name}"]["at_most"] for name in ("p50", "p99")}
    low, high = 0.9 * min(cpu.min(), *targets.values()), 1.15 * max(wall.max(), *targets.values())
    edges = list(np.geomspace(low, high, BINS))
    axes.hist(wall, bins=edges, color=BAR, edgecolor="white", linewidth=0.4)
    axes.hist(cpu, bins=edges, histtype="step", color=INK, linewidth=0.9)
    handles: list[Artist] = [Patch(color=BAR, label="wall time"), Patch(fill=False, ec=INK, label="CPU time")]
    for name, style in QUANTILES.items():
        found = summary[f"plan_ms_{name}"]
        axes.axvline(found, color=INK, linestyle=style, linewidth=1.2)
        label = f"{name}  {found:.3g} ms, CPU {summary[f'plan_cpu_ms_{name}']:.3g}"
        handles.append(Line2D([], [], color=INK, linestyle=style, linewidth=1.2, label=label))
    for name, marker in (("p50", "v"), ("p99", "D")):
        (mark,) = axes.plot(
            targets[name], 1.0, marker, color=TARGET, markersize=7, clip_on=False, linestyle="none",
            transform=axes.get_xaxis_transform(), label=f"target of {name}  {targets[name]:g} ms",
        )  # fmt: skip
        handles.append(mark)
    slow = [row["wall_ms"] for row in rows if row["path"] != "fast"]
    if slow:
        (mark,) = axes.plot(
            slow, [0.03] * len(slow), "x", color=INK, markersize=6, linestyle="none",
            transform=axes.get_xaxis_transform(), label=f"not on the fast path  {len(slow)}",
        )  # fmt: skip
        handles.append(mark)
    axes.set_ylabel("calls", fontsize=10)
    axes.set_title(f"one call of plan(), {len(rows):,} random tasks", fontsize=10, loc="left", pad=10)
    _log_time(axes, low, high)
    legend = axes.legend(handles=handles, fontsize=8, loc="upper right", framealpha=1.0, edgecolor="white")
    legend.set_zorder(5)


def _draw_parts(axes: Axes, rows: Rows) -> None:
    for place, part in enumerate(PARTS):
        low, middle, high = np.percentile([row[f"{part}_ms"] for row in rows], (1, 50, 99))
        axes.plot([low, high], [place, place], color=BAR, linewidth=5, solid_capstyle="butt")
        axes.plot(middle, place, "|", color=INK, markersize=13, markeredgewidth=2)
        label = f"{middle:.2g} ms, p99 {high:.2g}"
        axes.annotate(label, (high, place), (5, 0), textcoords="offset points", fontsize=8.5, va="center")
    least, most = np.percentile([[row[f"{part}_ms"] for row in rows] for part in PARTS], (1, 99), axis=1)
    axes.set_yticks(range(len(PARTS)), PARTS)
    axes.set_ylim(len(PARTS) - 0.4, -0.6)
    axes.set_title("its parts, wall time: median, 1 % to 99 %", fontsize=10, loc="left")
    _log_time(axes, 0.8 * min(least), max(most) * (max(most) / min(least)) ** 0.45)  # room for the last label


def _draw_methods(axes: Axes, calls: Rows, summary: Mapping[str, Any]) -> None:
    if not calls:
        axes.set_axis_off()
        return
    names = [name for name in NAMES if name in calls[0]]
    spread = np.linspace(-SPREAD, SPREAD, len(calls)) if len(calls) > 1 else np.zeros(1)
    for place, name in enumerate(names):
        solved = np.array([each[name]["status"] == "solved" for each in calls])
        times = 1e3 * np.array([each[name]["cpu_s"] for each in calls])
        axes.plot(times[solved], (place + spread)[solved], "o", color=BAR, markeredgecolor=INK, markersize=5, alpha=0.8)
        axes.plot(times[~solved], (place + spread)[~solved], "x", color=INK, markersize=6)
        median = 1e3 * summary["methods"][name]["time_median_s"]
        axes.plot([median, median], [place - 0.28, place + 0.28], color=INK, linewidth=2.2)
        label = _in_words(name, median, summary)
        axes.annotate(label, (median, place - 0.32), fontsize=8.5, ha="center", va="bottom", color=INK)
    shown = [1e3 * each[name]["cpu_s"] for each in calls for name in names]
    axes.set_yticks(range(len(names)), [NAMES[name] for name in names])
    axes.set_ylim(len(names) - 0.5, -0.75)
    axes.set_title(f"to a motion, CPU time; {len(calls)} tasks, each by all", fontsize=10, loc="left", pad=10)
    _log_time(axes, 0.2 * min(shown), 3.0 * max(shown))
    handles = [
        Line2D([], [], color=BAR, marker="o", markeredgecolor=INK, markersize=5, linestyle="none", label="solved"),
        Line2D([], [], color=INK, marker="x", markersize=6, linestyle="none", label="no motion found"),
        Line2D([], [], color=INK, linewidth=2.2, label="median"),
    ]
    axes.legend(handles=handles, fontsize=8, frameon=False, loc="lower left" if len(names) > 1 else "lower right")


def _in_words(name: str, median: float, summary: Mapping[str, Any]) -> str:
    told = summary["methods"][name]
    speedup = f", {summary['speedup'][name]['median']:.3g} × plan()" if name in summary["speedup"] else ""
    return f"{_milliseconds(median)}{speedup}\nbest cost on {told['optimal']} of {told['runs']}"


def _milliseconds(value: float) -> str:
    return f"{value:.3g} ms" if value < 1e3 else f"{value / 1e3:.3g} s"


def _log_time(axes: Axes, low: float, high: float) -> None:
    """A logarithmic x axis from `low` to `high` milliseconds."""
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    wide = np.log10(high / low) > NARROW
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if wide else (1.0, 2.0, 5.0), numticks=12))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: _milliseconds(value)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(labelsize=9)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.grid(axis="x", color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
