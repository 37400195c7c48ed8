"""State-space trajectories of whole regions, in the manner of Fig. 6 and 10."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gaitflow.core.task_space import TaskSpace
from gaitflow.core.trajectory import Array
from gaitflow.report import axis_text
from gaitflow.report.slices import main_axes
from gaitflow.report.winners import counted, most_common_pattern, trajectory_of
from gaitflow.search.solution import Solution

LABELS = (
    ("height z [m]", "ż [m/s]"),
    ("pitch [rad]", "pitch rate [rad/s]"),
    ("roll [rad]", "roll rate [rad/s]"),
)
MEAN_COLOUR = "#D1007A"
LONG_NAME = 24  # characters; a longer one would run into the next panel


def draw_state_space(regions: Mapping[str, Sequence[Solution]], space: TaskSpace) -> Figure:
    """One row a gait: height, pitch and in space roll, each against its rate; a line a task, coloured by its speed.

    Where speed is fixed, the map's first axis takes its place.

    The bold line is the region's mean, knot by knot, over the tasks that share its most common pattern: the nominal
    motion that starts an optimiser (section IV.B). Gaits without a trajectory are left out. Raises ValueError when
    none is left.
    """
    shown = {name: region for name, region in regions.items() if region}
    if not shown:
        raise ValueError("no gait has a stored trajectory; pass solutions with trajectories")
    axis, _ = main_axes(space)
    values = [solution.task[axis] for region in shown.values() for solution in region]
    shade = ScalarMappable(Normalize(min(values), max(values)), colormaps["viridis"])
    figure = Figure(figsize=(8.4, 0.4 + 2.1 * len(shown)), dpi=150, layout="constrained")
    columns = max(len(planes(trajectory_of(region[0]).base)) for region in shown.values())
    grid = figure.subplots(len(shown), columns, squeeze=False)
    for (name, region), row in zip(shown.items(), grid, strict=True):
        for plane, axes in enumerate(row):
            _draw_plane(axes, region, plane, shade.to_rgba(np.array([one.task[axis] for one in region])))
            axes.set_xlabel(LABELS[plane][0], fontsize=10)
            axes.set_ylabel(LABELS[plane][1], fontsize=10)
        row[0].set_title(name, fontsize=11 if len(name) <= LONG_NAME else 8, loc="left")
        row[-1].set_title(counted(len(region)), fontsize=9, loc="right", color="#555555")
    bar = figure.colorbar(shade, ax=grid, location="right", aspect=17 * len(shown), pad=0.02)
    bar.set_label(axis_text.label(axis), fontsize=10)
    return figure


def _draw_plane(axes: Axes, region: Sequence[Solution], plane: int, colours: Array) -> None:
    for solution, colour in zip(region, colours, strict=True):
        x, y = planes(trajectory_of(solution).base)[plane]
        axes.plot(x, y, color=colour, linewidth=0.9, alpha=0.8)
    loops = [planes(trajectory_of(solution).base)[plane] for solution in most_common_pattern(region)]
    x, y = np.mean(loops, axis=0)
    axes.plot(x, y, color="white", linewidth=4.2)
    axes.plot(x, y, color=MEAN_COLOUR, linewidth=2.4)
    axes.tick_params(labelsize=9)
    axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.ticklabel_format(scilimits=(-2, 3), useOffset=False, useMathText=True)
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_offset_text().set_fontsize(8)
    axes.grid(color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)


def planes(base: Array) -> tuple[tuple[Array, Array], ...]:
    """(z, its rate), (pitch, its rate) and in space (roll, its rate), each [K+1], of base states [K+1, nb].

    In space (nb = 12) the rates of pitch and roll are the second and first angular velocities in the base frame; in
    the plane nb = 6. Raises ValueError for another nb.
    """
    if base.shape[1] == 6:
        return (base[:, 1], base[:, 4]), (base[:, 2], base[:, 5])
    if base.shape[1] == 12:
        return (base[:, 2], base[:, 8]), (base[:, 4], base[:, 10]), (base[:, 5], base[:, 9])
    raise ValueError(f"base states have {base.shape[1]} columns; 6 (plane) or 12 (space) are expected")
