"""A way from one gait to another: its contacts, its two ends, and the start from which its motion is solved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.motion.phase_start import PhaseStart
from gaitflow.motion.place import Place

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Way:
    """A way from the gait that is left at `first` to the one that is joined at `last`.

    contacts [phases, legs]: some of the first gait's from there on, then those of the other one that lead to `last`.
    durations [phases] s: where a solver starts.
    """

    first: PhaseStart
    last: PhaseStart
    contacts: Mask
    durations: Array

    @property
    def pattern(self) -> str:
        """The contacts as "0110/1100"."""
        return "/".join("".join("01"[int(stands)] for stands in row) for row in self.contacts.T)


def end_states(way: Way, task: Task) -> tuple[Array, Array]:
    """The states [nx] that a way leads between, in the frame of the command at its start."""
    first = np.concatenate([way.first.base, way.first.feet.ravel()])
    there = Place.commanded(task, task.cycle_duration)
    return first, np.concatenate([there.bodies(way.last.base), there.points(way.last.feet).ravel()])


def stances(row: Mask) -> list[tuple[int, int]]:
    """First phase and the one after the last of each stance."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(int)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def interpolated(scenario: Mapping[str, Any], way: Way, first: Array, last: Array, times: Array) -> Trajectory:
    """From the first to the last state [nx]: the base on a cubic, feet on lines between footholds, the weight shared.

    times [K + 1] s are those of the knots. A stance that reaches neither end is where the default place of the foot is
    in its middle.
    """
    default = np.array([leg["default_foot"] for leg in scenario["robot"]["legs"]])
    legs, d = default.shape
    nb, steps = len(first) - legs * d, (len(times) - 1) // len(way.durations)
    share = times[:, None] / times[-1]
    base = first[:nb] + share * (last[:nb] - first[:nb])
    base[:, :d] = _hermite(share, times[-1], first, last, d, nb)
    ends = first[nb:].reshape(legs, d), last[nb:].reshape(legs, d)
    feet = np.empty((len(times), legs, d))
    for leg, row in enumerate(way.contacts.T):
        known = {0: ends[0][leg], len(times) - 1: ends[1][leg]}
        for start, stop in stances(row):
            a, b = start * steps, stop * steps
            beside = (base[a, :d] + base[b, :d]) / 2 + default[leg]
            beside[-1] = 0.0
            place = known.get(a, known.get(b, beside))
            known = {a: place, b: place} | known
        at = sorted(known)
        for axis in range(d):
            feet[:, leg, axis] = np.interp(times, times[at], [known[knot][axis] for knot in at])
    stands = np.repeat(way.contacts, steps, axis=0)
    forces = np.zeros((len(times) - 1, legs, d))
    carried = float(scenario["robot"]["mass"]) * GRAVITY / np.maximum(stands.sum(axis=1, keepdims=True), 1)
    forces[..., -1] = stands * carried
    speeds = np.diff(feet, axis=0) / np.diff(times)[:, None, None]
    return Trajectory(times, base, feet, forces, forces, speeds, way.durations)


def _hermite(share: Array, duration: float, first: Array, last: Array, d: int, nb: int) -> Array:
    """The cubic through both positions with both velocities [n, d], at shares [n, 1] of the duration [s]."""
    speeds = slice(nb // 2, nb // 2 + d)
    way = last[:d] - first[:d]
    leaving, arriving = duration * first[speeds], duration * last[speeds]
    square, cube = 3 * way - 2 * leaving - arriving, leaving + arriving - 2 * way
    found: Array = first[:d] + share * (leaving + share * (square + share * cube))
    return found
