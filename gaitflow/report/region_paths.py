"""The regions of one slice of a map as SVG paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gaitflow.report.decisions import Select, decisions
from gaitflow.report.map_panel import Mask


def region_paths(
    select: Select,
    axes: Mapping[str, tuple[float, float]],
    at: Mapping[str, float],
    resolution: int,
    gaits: Sequence[str],
) -> dict[str, str]:
    """The path of each gait that `select` chooses somewhere in a slice, for a box [0, resolution] in each direction.

    `axes` has the (low, high) of the axes along x and, if there is a second one, along y; y rises. `at` has the values
    of the further axes. Cells stand for their middles. Raises ValueError when `select` answers with an index that is no
    gait.
    """
    middles = (np.arange(resolution) + 0.5) / resolution
    along = {axis: low + (high - low) * middles for axis, (low, high) in axes.items()}
    # A map of one axis is a strip, every row of it alike.
    chosen = np.broadcast_to(decisions(select, along, at, len(gaits)), (resolution, resolution))
    return {gaits[index]: outline(chosen == index) for index in np.unique(chosen[chosen >= 0])}


def outline(inside: Mask) -> str:
    """An SVG path over the cells [rows, columns] that are inside: rectangles, as tall as a run of cells repeats."""
    begun: dict[tuple[int, int], int] = {}
    parts = []
    for row in range(len(inside) + 1):
        runs = _runs(inside[row]) if row < len(inside) else []
        for run in [each for each in begun if each not in runs]:
            first, width = begun.pop(run), run[1] - run[0]
            parts.append(f"M{run[0]} {first}h{width}v{row - first}h-{width}z")
        for run in runs:
            begun.setdefault(run, row)
    return "".join(parts)


def _runs(cells: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(first, end) of each run of cells that are inside."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], cells, [False]]).astype(int)))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]
