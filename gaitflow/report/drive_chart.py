"""A drive as one picture: the speed that was commanded and the robot's, over the gaits that it went in."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO

from matplotlib.figure import Figure
from matplotlib.patches import Patch

from gaitflow.core.trajectory import Array
from gaitflow.report.palette import gait_colours, lighter

STANDING_COLOUR = "#DDDDDD"
INK, SPEED = "#222222", "#D55E00"


def drive_chart(
    times: Array, commanded: Array, speeds: Array, gaits: Sequence[tuple[float, str | None]], title: str
) -> bytes:
    """A PNG of commanded and driven speeds [n] m/s at times [n] s; gaits: since when [s] each was followed, in order.

    A gait of None is a stand.
    """
    names = list(dict.fromkeys(gait for _, gait in gaits if gait is not None))
    colours = gait_colours(names)
    figure = Figure(figsize=(11.0, 4.0), dpi=120, layout="constrained")
    axes = figure.subplots()
    ends = [*(since for since, _ in gaits[1:]), float(times[-1])]
    for (since, gait), end in zip(gaits, ends, strict=True):
        colour = STANDING_COLOUR if gait is None else lighter(colours[gait], 0.55)
        axes.axvspan(since, end, color=colour, linewidth=0)
        axes.axvline(since, color="white", linewidth=0.8)
    axes.plot(times, commanded, color=INK, linestyle="--", linewidth=1.3, label="commanded")
    axes.plot(times, speeds, color=SPEED, linewidth=1.6, label="driven, mean over 1 s")
    axes.set_xlim(float(times[0]), float(times[-1]))
    axes.set_ylim(bottom=min(0.0, float(speeds.min())))
    axes.set_xlabel("time [s]", fontsize=9)
    axes.set_ylabel("speed [m/s]", fontsize=9)
    axes.set_title(title, fontsize=10, loc="left")
    patches = [Patch(color=lighter(colours[name], 0.55), label=name) for name in names]
    stand = [Patch(color=STANDING_COLOUR, label="stands")] if any(gait is None for _, gait in gaits) else []
    axes.legend(
        handles=[*axes.get_legend_handles_labels()[0], *patches, *stand],
        fontsize=8,
        loc="center left",
        bbox_to_anchor=(1.0, 0.5),
        frameon=False,
    )
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()
