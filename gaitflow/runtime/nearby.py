"""Which of an atlas' nodes are near a place, and what they weigh there; all lengths in steps of the axes.

Distance alone does not say how well a node predicts at a place: at a cliff its slope holds for a hundredth of a step,
and across a kink it belongs to another motion. So a node weighs less if it expects the cost to change much up to the
place, and less again if its prediction there is far from the blend of all nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

REACH = 1.5  # nodes further away say nothing about a place
NEAREST = 1e-6  # the least distance that weights tell apart
STEEP, ODD = 0.3, 0.1  # change of a cost's logarithm, and what a promise of it is off, that halve a node's weight
ROUNDS = 2  # of comparing promises: a third one changes nothing that matters


@dataclass(frozen=True, eq=False)
class Near:
    """n nodes near a place, of `count` sheets: the ones that own them, and their weights, both [n].

    offsets, slopes: one [n] along each axis, from the place and of the cost's logarithm; logs [n] are that logarithm.
    """

    count: int
    owner: NDArray[np.intp]
    weights: Array
    offsets: list[Array]
    logs: Array
    slopes: list[Array]

    @cached_property
    def promises(self) -> Array:
        """The logarithm of the cost at the place that each node promises by its slopes [n]."""
        return self.logs - self._change

    def agreed(self) -> Array:
        """The weights [n] by distance, steepness and agreement."""
        steady = self.weights / (1 + (self._change / STEEP) ** 2)
        weights = steady
        for _ in range(ROUNDS):
            off = self.promises - self.blended(weights)[self.owner]
            weights = steady / (1 + (off / ODD) ** 2)
        return weights

    def blended(self, weights: Array) -> Array:
        """The logarithm of each sheet's cost at the place [count] by weights [n]: tangents are followed half-way."""
        sums = self._sums(weights[:, None] * self._columns)
        total, axes = sums[0], len(self.offsets)
        mixed: Array = (sums[1] - (sums[2 : 2 + axes] * sums[2 + axes :]).sum(axis=0) / total / 2) / total
        return mixed

    def _sums(self, terms: Array) -> Array:
        """Over the nodes of each sheet, of terms [n, k]; [k, count]."""
        sums: Array = (self._of_sheet @ terms).T
        return sums

    @cached_property
    def _of_sheet(self) -> Array:
        """1 where a sheet owns a node [count, n], else 0."""
        return (self.owner == np.arange(self.count)[:, None]).astype(np.float64)

    @cached_property
    def _columns(self) -> Array:
        """What is summed [n, 2 + 2a]: 1, the promises of half a tangent, offsets and slopes."""
        return np.stack([np.ones(len(self.logs)), self.logs - self._change / 2, *self.offsets, *self.slopes], axis=1)

    @cached_property
    def _change(self) -> Array:
        """Of the logarithm, from the place to each node by its slopes [n]."""
        pairs = zip(self.offsets, self.slopes, strict=True)
        return sum((offset * slope for offset, slope in pairs), np.zeros(len(self.logs)))


class NearMany(Near):
    """The same of many places at once: a node is there once for each, and each place has sheets of its own."""

    # A matrix of all sheets of all places would be large. `Near` keeps its product, since starts of nodes, and by their
    # last digits the keys of nodes that are kept, depend on it.
    def _sums(self, terms: Array) -> Array:
        return np.stack([np.bincount(self.owner, term, self.count) for term in terms.T])


class EveryNode:
    """The nodes of all sheets as columns, in the order of their first axis, so that few of them are looked at."""

    def __init__(self, sheets: Sequence[tuple[Array, Array, Array]], axes: int) -> None:
        """Of each sheet, in steps: places [n, a] of its nodes, logarithms of their costs [n], and slopes [n, a]."""
        self.count = len(sheets)
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
            count=self.count,
            owner=self.sheets[low:high][near],
            weights=weights_of(np.sqrt(squared[near])),
            offsets=[offset[near] for offset in offsets],
            logs=self.logs[low:high][near],
            slopes=[slope[low:high][near] for slope in self.slopes],
        )

    def near_many(self, places: Array) -> NearMany:
        """The nodes within reach of each place [m, a], in steps; sheet s of place i is number i * count + s."""
        low, high = _window(self.places[0], places)
        offsets = [column[low:high] - values[:, None] for column, values in zip(self.places, places.T, strict=True)]
        squared = sum((offset * offset for offset in offsets), np.zeros((len(places), high - low)))
        place, near = np.nonzero(squared < REACH * REACH)
        return NearMany(
            count=len(places) * self.count,
            owner=place * self.count + self.sheets[low:high][near],
            weights=weights_of(np.sqrt(squared[place, near])),
            offsets=[offset[place, near] for offset in offsets],
            logs=self.logs[low:high][near],
            slopes=[slope[low:high][near] for slope in self.slopes],
        )


class EveryPlace:
    """Places of all sheets that have nothing but their distance, in the order of their first axis."""

    def __init__(self, sheets: Sequence[Array], axes: int) -> None:
        """Of each sheet its places [n, a], in steps."""
        self.count = len(sheets)
        places = np.concatenate([np.zeros((0, axes)), *sheets])
        order = np.argsort(places[:, 0], kind="stable")
        self.places = places[order]
        self.sheets = np.repeat(np.arange(len(sheets)), [len(each) for each in sheets])[order]

    def weights_near(self, place: Array) -> Array:
        """The sum of the weights by distance of each sheet's places within reach of one, in steps [count]."""
        if not len(self.places):
            return np.zeros(self.count)
        low, high = np.searchsorted(self.places[:, 0], (place[0] - REACH, place[0] + REACH))
        squared = ((self.places[low:high] - place) ** 2).sum(axis=1)
        near = np.flatnonzero(squared < REACH * REACH)
        weights = weights_of(np.sqrt(squared[near]))
        return np.bincount(self.sheets[low:high][near], weights, self.count).astype(np.float64)

    def weights_near_many(self, places: Array) -> Array:
        """The same for each place [m, a], of sheet s of place i as number i * count + s [m * count]."""
        low, high = _window(self.places[:, 0], places)
        squared = ((self.places[low:high] - places[:, None]) ** 2).sum(axis=2)
        place, near = np.nonzero(squared < REACH * REACH)
        weights, owner = weights_of(np.sqrt(squared[place, near])), place * self.count + self.sheets[low:high][near]
        return np.bincount(owner, weights, len(places) * self.count).astype(np.float64)


def _window(sorted_column: Array, places: Array) -> tuple[int, int]:
    """Where in a column of first coordinates those are that may be within reach of any of the places [m, a]."""
    low, high = np.searchsorted(sorted_column, (places[:, 0].min() - REACH, places[:, 0].max() + REACH))
    return int(low), int(high)


def weights_of(distances: Array) -> Array:
    """What nodes weigh in a prediction by their distances, in steps."""
    closeness = (REACH - distances) / (REACH * np.maximum(distances, NEAREST))
    weights: Array = closeness * closeness * closeness
    return weights
