"""Gait diagrams in the manner of Fig. 5, with the phase durations that the solved motions really have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitflow.core.trajectory import Array
from gaitflow.report.palette import kind_and_contacts, lighter
from gaitflow.report.winners import counted, mean_phase_fractions, most_common_pattern
from gaitflow.search.solution import Solution

COLUMNS = 3
BAR = 0.62  # height of a leg's bar


def draw_gait_diagrams(
    regions: Mapping[str, Sequence[Solution]], leg_names: Sequence[str], colours: Mapping[str, str]
) -> Figure:
    """One small diagram a gait, in the order given: a bar where a leg stands, over the cycle in per cent.

    Phase durations are means over the region's tasks that share its most common pattern. `regions` comes from
    `winners`; gaits without a trajectory are left out. Raises ValueError when none is left.
    """
    shown = {name: most_common_pattern(region) for name, region in regions.items() if region}
    if not shown:
        raise ValueError("no gait has a stored trajectory; pass solutions with trajectories")
    columns = min(COLUMNS, len(shown))
    rows = math.ceil(len(shown) / columns)
    two_lines = any(kind_and_contacts(name)[1] for name in shown)
    figure = Figure(
        figsize=(8.4, rows * (0.85 + 0.3 * len(leg_names) + 0.2 * two_lines)), dpi=150, layout="constrained"
    )
    for place, (name, region) in enumerate(shown.items()):
        axes = figure.add_subplot(rows, COLUMNS, 1 + COLUMNS * (place // columns) + place % columns)
        fractions = mean_phase_fractions(region)
        draw_contacts(axes, region[0].pattern, 100 * fractions, leg_names, colours[name])
        kind, contacts = kind_and_contacts(name)
        axes.set_title(f"{kind}\n" if two_lines else kind, fontsize=11, loc="left")
        if contacts:
            axes.annotate(
                contacts,
                (0, 1),
                (0, 4),
                "axes fraction",
                "offset points",
                fontsize=8,
                color="#555555",
                family="monospace",
            )
        axes.set_title(counted(len(regions[name])), fontsize=9, loc="right", color="#555555")
        if place + columns >= len(shown):
            axes.set_xlabel("share of the cycle [%]", fontsize=9)
    return figure


def draw_contacts(axes: Axes, pattern: str, durations: Array, leg_names: Sequence[str], colour: str) -> None:
    """Contact bars of all legs, the first on top: solid where the leg stands, pale where it swings.

    `pattern` has a row of digits a leg, joined by "/"; `durations` [phases] are in the unit of the x axis.
    """
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    rows = pattern.split("/")
    for place, row in enumerate(rows):
        axes.barh(place, edges[-1], height=BAR, color=lighter(colour, 0.8), linewidth=0)
        for phase, digit in enumerate(row):
            if digit == "1":
                axes.barh(place, durations[phase], left=edges[phase], height=BAR, color=colour, linewidth=0)
    for edge in edges[1:-1]:
        axes.axvline(edge, color="white", linewidth=0.8, linestyle=(0, (2, 2)))
    axes.set_yticks(range(len(rows)), list(leg_names), fontsize=10)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(0, edges[-1])
    axes.tick_params(axis="x", labelsize=9)
    axes.tick_params(axis="y", length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
