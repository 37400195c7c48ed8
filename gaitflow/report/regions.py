"""The labelled task grid as a picture of gaits: windows of tasks, connected regions and which gaits they border."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import ndimage

from gaitflow.core.gaits import Pattern

Mask = NDArray[np.bool_]
INFEASIBLE = ""  # gait of a grid task that no pattern solves
NEAR = 1e-6  # m/s or s: window limits include grid values that differ by rounding


@dataclass(frozen=True)
class GaitGrid:
    """Best gaits on a rectangular task grid.

    speeds [n] m/s rising; durations [m] s rising; gaits [n, m] names, "" where the task is infeasible or was not
    part of the grid; ties [n, m] sets of the names that cost the same within the tie tolerance; flies [n, m] whether
    no foot stands in some phase of the gait. Of a map with further axes it holds one slice. merged: names that stand
    for one gait here, each with the one that the map calls it by.
    """

    speeds: NDArray[np.float64]
    durations: NDArray[np.float64]
    gaits: NDArray[np.object_]
    ties: NDArray[np.object_]
    flies: Mask
    merged: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_labels(cls, labels: pd.DataFrame, merged: Mapping[str, str] | None = None) -> GaitGrid:
        """The grid tasks of a labels frame. Raises ValueError without one, and for several slices."""
        grid = labels[labels["split"] == "grid"]
        if grid.empty:
            raise ValueError(
                "the labels have no task of the split 'grid': only a map whose tasks are a grid has regions"
            )
        rounded = grid.assign(speed=grid["speed"].round(9), cycle_duration=grid["cycle_duration"].round(9))
        if rounded.duplicated(["speed", "cycle_duration"]).any():
            raise ValueError("the labels have several tasks at one speed and cycle duration; pass one slice of the map")
        called = dict(merged or {})
        speeds = np.sort(rounded["speed"].unique()).astype(float)
        durations = np.sort(rounded["cycle_duration"].unique()).astype(float)
        gaits = np.full((len(speeds), len(durations)), INFEASIBLE, dtype=object)
        ties = np.full(gaits.shape, frozenset(), dtype=object)
        flies = np.zeros(gaits.shape, dtype=bool)
        for row in rounded[rounded["status"] == "solved"].to_dict("records"):
            at = np.searchsorted(speeds, row["speed"]), np.searchsorted(durations, row["cycle_duration"])
            gaits[at] = called.get(row["gait"], row["gait"])
            ties[at] = frozenset(called.get(name, name) for name in (*row["ties"], row["gait"]))
            gait = Pattern.from_text(row["gait_key"])
            flies[at] = any(not any(gait.column(phase)) for phase in range(gait.phases))
        return cls(speeds, durations, gaits, ties, flies, called)

    @property
    def feasible(self) -> Mask:
        """Tasks with a best gait, [n, m]."""
        return np.asarray(self.gaits != INFEASIBLE, dtype=bool)

    @property
    def names(self) -> tuple[str, ...]:
        """Gaits that are best at some task, sorted."""
        return tuple(sorted(set(self.gaits[self.feasible])))

    def window(
        self, speed: tuple[float, float] = (-np.inf, np.inf), duration: tuple[float, float] = (-np.inf, np.inf)
    ) -> Mask:
        """Feasible tasks with speed [m/s] and cycle duration [s] within closed intervals, [n, m]."""
        in_speed = (self.speeds >= speed[0] - NEAR) & (self.speeds <= speed[1] + NEAR)
        in_duration = (self.durations >= duration[0] - NEAR) & (self.durations <= duration[1] + NEAR)
        return self.feasible & in_speed[:, None] & in_duration[None, :]

    def at(self, speeds: NDArray[np.float64], durations: NDArray[np.float64]) -> GaitGrid:
        """The part of the map on some of its speeds and durations (both must be on the grid)."""
        rows, columns = np.searchsorted(self.speeds, speeds), np.searchsorted(self.durations, durations)
        at = np.ix_(rows, columns)
        parts = self.gaits[at], self.ties[at], self.flies[at]
        return GaitGrid(self.speeds[rows], self.durations[columns], *parts, self.merged)

    def best(self, gait: str) -> Mask:
        """Tasks at which `gait` costs least, [n, m]."""
        return np.asarray(self.gaits == self.merged.get(gait, gait), dtype=bool)

    def best_or_tied(self, gait: str) -> Mask:
        """Tasks at which `gait` costs least within the tie tolerance, [n, m]."""
        name = self.merged.get(gait, gait)
        return np.array([[name in names for names in row] for row in self.ties], dtype=bool)

    def regions(self, gait: str) -> tuple[Mask, ...]:
        """Connected regions of a gait, largest first; tasks touch along an edge of the grid, not at a corner."""
        numbered, count = ndimage.label(self.best(gait))
        masks = [np.asarray(numbered == number, dtype=bool) for number in range(1, count + 1)]
        return tuple(sorted(masks, key=lambda mask: -int(mask.sum())))

    def borders(self, region: Mask) -> frozenset[str]:
        """Gaits of the tasks that touch the region from outside."""
        ring = ndimage.binary_dilation(region) & ~region & self.feasible
        return frozenset(self.gaits[ring])

    def third(self, axis: str, which: int) -> tuple[float, float]:
        """Closed interval of the lower (0), middle (1) or upper (2) third of the axis "speed" or "duration"."""
        values = self.speeds if axis == "speed" else self.durations
        edges = np.linspace(values[0], values[-1], 4)
        return float(edges[which]), float(edges[which + 1])
