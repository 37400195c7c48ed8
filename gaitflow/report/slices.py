"""A map over any axes as pictures of two: the tasks that agree on all axes but the two main ones make a panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from gaitflow.core.task_space import MAIN_AXES, TaskSpace

MAX_PANELS = 9
DECIMALS = 9  # grid values are rounded to 1e-9


@dataclass(frozen=True)
class Slice:
    """Tasks at one value of every further axis: these values, and the rows of the labels."""

    at: dict[str, float]
    labels: pd.DataFrame


@dataclass(frozen=True)
class Slices:
    """The panels of a map, with what is on their axes; y is None for a map with one axis.

    `count` is how many there are to choose from; `between` how many held-out tasks lie between them, in none.
    """

    x: str
    y: str | None
    panels: tuple[Slice, ...]
    count: int
    between: int

    @property
    def remark(self) -> str:
        """What a reader must know of what is not drawn; "" when all is."""
        parts = []
        if len(self.panels) < self.count:
            parts.append(f"{len(self.panels)} of {self.count} slices of the map are drawn, evenly chosen.")
        if self.between:
            parts.append(f"{self.between} held-out tasks lie between the slices and are not drawn.")
        return " ".join(parts)


def main_axes(space: TaskSpace) -> tuple[str, str | None]:
    """Speed and cycle duration where both have a range, otherwise the first two axes with one, or the only one."""
    first, *others = MAIN_AXES if set(MAIN_AXES) <= set(space.ranged) else space.ranged
    return first, others[0] if others else None


def slices_of(labels: pd.DataFrame, space: TaskSpace, most: int | None = MAX_PANELS) -> Slices:
    """The panels of a labels frame, by rising values of the further axes; at most `most`, the outermost kept.

    Raises ValueError when there is no task.
    """
    if labels.empty:
        raise ValueError("the labels have no task; solve the scenario first")
    x, y = main_axes(space)
    further = [axis for axis in space.ranged if axis not in (x, y)]
    if not further:
        return Slices(x, y, (Slice({}, labels),), 1, 0)
    rounded = labels[further].round(DECIMALS)
    on_grid = rounded[labels["split"] == "grid"].drop_duplicates().sort_values(further)
    places = (on_grid if len(on_grid) else rounded.drop_duplicates().sort_values(further)).to_dict("records")
    chosen = np.unique(np.linspace(0, len(places) - 1, min(len(places), most or len(places))).round().astype(int))
    inside = [(rounded == pd.Series(place)).all(axis=1) for place in places]
    panels = tuple(
        Slice({str(axis): float(value) for axis, value in places[i].items()}, labels[inside[i]]) for i in chosen
    )
    between = int((~np.logical_or.reduce(inside)).sum())
    return Slices(x, y, panels, len(places), between)
