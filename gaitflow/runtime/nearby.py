"""Which of an atlas' nodes are near a place, and what they weigh there; all lengths in steps of the axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

REACH = 1.5  # nodes further away say nothing about a place
NEAREST = 1e-6  # the least distance that weights tell apart


@dataclass(frozen=True, eq=False)
class Near:
    """n nodes near a place: the sheets that own them, and their weights, both [n].

    offsets, slopes: one [n] along each axis, from the place and of the cost's logarithm; logs [n] are that logarithm.
    """

    owner: NDArray[np.intp]
    weights: Array
    offsets: list[Array]
    logs: Array
    slopes: list[Array]


class EveryNode:
    """The nodes of all sheets as columns, in the order of their first axis, so that few of them are looked at."""

    def __init__(self, sheets: Sequence[tuple[Array, Array, Array]], axes: int) -> None:
        """Of each sheet, in steps: places [n, a] of its nodes, logarithms of their costs [n], and slopes [n, a]."""
        if not sheets:
            self.places = self.slopes = [np.zeros(0)] * axes
            self.logs, self.sheets = np.zeros(0), np.zeros(0, dtype=np.intp)
            return
        places = np.concatenate([places for places, _, _ in sheets])
        order = np.argsort(places[:, 0], kind="stable")
        slopes = np.concatenate([slopes for _, _, slopes in sheets])[order]
        self.places = [np.ascontiguousarray(column) for column in places[order].T]
        self.slopes = [np.ascontiguousarray(column) for column in slopes.T]
        self.logs = np.concatenate([logs for _, logs, _ in sheets])[order]
        self.sheets = np.repeat(np.arange(len(sheets)), [len(logs) for _, logs, _ in sheets])[order]

    def near(self, place: Array) -> Near:
        """The nodes within reach of a place, in steps."""
        low, high = np.searchsorted(self.places[0], (place[0] - REACH, place[0] + REACH))
        offsets = [column[low:high] - value for column, value in zip(self.places, place, strict=True)]
        squared = sum(offset * offset for offset in offsets)
        near = np.flatnonzero(squared < REACH * REACH)
        return Near(
            owner=self.sheets[low:high][near],
            weights=weights_of(np.sqrt(squared[near])),
            offsets=[offset[near] for offset in offsets],
            logs=self.logs[low:high][near],
            slopes=[slope[low:high][near] for slope in self.slopes],
        )


def weights_of(distances: Array) -> Array:
    """What nodes weigh in a prediction by their distances, in steps."""
    closeness = (REACH - distances) / (REACH * np.maximum(distances, NEAREST))
    weights: Array = closeness * closeness * closeness
    return weights
