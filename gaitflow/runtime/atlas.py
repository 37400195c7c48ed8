"""The atlas: solved tasks of every gait, from which costs and starts at any task between them are predicted.

A sheet belongs to one pattern of a gait. A node of it is a solved task: it holds the cost and the primal-dual
point on the central path, as coordinates along the sheet's own modes, and the derivatives (tangents) of both with
respect to the task. Nodes lie anywhere. A gait may have several sheets, as which phases it repeats may depend on the
task.

**How a number is predicted at a place x** (a cost's logarithm, or coordinates), all lengths in `steps` of the axes:

1. The nodes p_i of the sheet that are nearer than REACH = 1.5 take part, with weights v_i that are the cubes of
   (REACH - d) / (REACH d), d = |p_i - x| but 1e-6 at the least.
2. A node that expects the logarithm of the cost to change by c up to x weighs v_i / (1 + (c / STEEP)^2), STEEP = 0.3.
   Rule 4 with these weights comes to a cost; one whose own promise is off that by q weighs 1 / (1 + (q / ODD)^2) times
   as much, ODD = 0.1; and so once more. The weights w_i are these, divided by their sum.
3. For coordinates, and for the cost that comes with them (`predict`), nodes are left out whose first-order prediction
   c_i + T_i (x - p_i) is further than `tear` from that of the nearest node; `costs`, for all sheets, asks all nodes.
4. With m = sum of w_i (p_i - x), by how much the nodes' centre is off x, the prediction is the sum of
   w_i (c_i - T_i (p_i - x + m) / 2).
5. Over more than NEAR_AXES = 3 axes the cost that comes with coordinates is at most e times off those of the nodes
   that they are from.

**Where a sheet is believed.** Its support is 1 - |m| / REACH, by distance alone, times the share of its nodes in the
weights of nodes and of places where the pattern was tried and has no motion, weighed in the same way. A cost alone does
not tell where a gait ends: up to a limit of the robot it hardly changes, and one step further there is no motion.

**Which gait comes first.** The one of least cost, of those that are believed. Over more than NEAR_AXES axes nodes are
too far apart to tell gaits by their costs alone: there a cost counts over the classifier's probability of the gait, and
half of the support will do.

With one node, 4 is its first-order prediction. Amid several it follows each tangent half of the way, which is nearly
right to second order (m is small there), where whole tangents are only to first: they all err to the same side of a
bent curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.runtime.condensed import Condenser
from gaitflow.runtime.nearby import REACH, EveryNode, EveryPlace, Near, weights_of
from gaitflow.runtime.sheet_image import SheetImage
from gaitflow.solvers.point import GaitSpace

SUPPORT = 0.7  # of a cost that is believed: the nodes' centre is at most 0.45 steps off
TRIED = SUPPORT / 2  # of a cost that a plan tries to reach: half of the gaits that were missed are not believed;
HARDLY_TRIED, HARDLY = 0.1, 2.0  # or from this on, where even so many times the prediction would be cheaper
DOUBT = 0.5  # of the spread of the nodes' promises: a cost is seldom further below its prediction
# Over more axes than these nodes lie so far apart that their spread says little. None of 100 plans over four axes got
# dearer without the rivals whose prediction is more than MOST_BELOW times the best cost.
NEAR_AXES, MOST_BELOW = 3, 1.1
# Of the logarithm of a start's cost, from its nodes'. Between nodes so far apart tangents promise thousands of times: a
# start that divides by such a cost leads nowhere. By one ten times off it leads to the same motion.
MOST_OFF = 1.0
LEAST_CHANCE = 1e-6  # of a gait: those that the classifier rules out are still ordered by cost
ALIKE = 1e-4  # relative: straight ahead a gait and its mirror image cost the same but for rounding
LARGEST_LOG = 200.0  # of a cost, so that it and its products with stored numbers are finite


@dataclass(frozen=True, eq=False)
class Sheet:
    """One pattern, "0110/1100", of the map's gait number `gait`: n nodes, k modes of c numbers, on a axes.

    space: the bounds that impose the pattern. tasks [n, a]: places of the nodes, in the atlas' axes and their units.
    costs [n]: the problem's (scaled) cost at the optimum; slopes [n, a]: derivatives of its logarithm. A node's point,
    condensed (`gaitflow.runtime.condensed`; in older maps encoded, of more numbers), is mean [c] + coordinates [n, k] @
    modes [k, c]; tangents [n, a, k]: derivatives of its coordinates. Nodes whose coordinates, moved to one place along
    their tangents, differ by more than `tear` belong to different motions and are not blended. infeasible [m, a]:
    places where the pattern was tried and has no motion.
    """

    gait: int
    pattern: str
    space: GaitSpace
    tasks: Array
    costs: Array
    slopes: Array
    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    coordinates: NDArray[np.float32]
    tangents: NDArray[np.float32]
    tear: float
    infeasible: Array
    image: SheetImage | None = None  # of another sheet, from which a file makes this one


@dataclass(frozen=True)
class Prediction:
    """The start of a sheet at a task: its cost, the problem's, and its point [ny] on the central path."""

    cost: float
    point: Array


@dataclass(frozen=True, eq=False)
class Atlas:
    """The sheets over a ranged axes, in the order of the map's; places [a] are values on them, in their units.

    `steps` [a] is the typical distance of neighbouring nodes along each axis, the unit of all lengths; `barrier` that
    of the central path that the nodes lie on, for a cost divided by its optimum.
    """

    axes: tuple[str, ...]
    steps: Array
    barrier: float
    sheets: tuple[Sheet, ...]

    @classmethod
    def empty(cls, axes: Sequence[str]) -> Atlas:
        """An atlas that knows nothing."""
        return cls(tuple(axes), np.ones(len(axes)), 1e-4, ())

    @property
    def is_wide(self) -> bool:
        """Whether it ranges over more than NEAR_AXES axes."""
        return len(self.axes) > NEAR_AXES

    def of(self, gaits: Sequence[int]) -> Atlas:
        """The sheets of some of the gaits, which become numbers 0, 1, ... in the order of `gaits`."""
        number = {gait: new for new, gait in enumerate(gaits)}
        kept = (sheet for sheet in self.sheets if sheet.gait in number)
        return replace(self, sheets=tuple(replace(sheet, gait=number[sheet.gait]) for sheet in kept))

    def costs(self, place: Array) -> tuple[Array, Array]:
        """The problem's cost of each sheet at a place, and how well its nodes surround the place, its support.

        Support is 1 amid or upon nodes, less beyond the last ones and towards places without a motion. Where it is 0
        there is no node within reach, and the cost is NaN.
        """
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            asked = place / self.steps
            return _costs_and_support(self._every.near(asked), self._every_infeasible.weights_near(asked))

    def costs_of_many(self, places: Array) -> tuple[Array, Array]:
        """`costs` of many places [m, a] at once, both [m, sheets]: as exact, though not to the last digit the same."""
        shape = len(places), len(self.sheets)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            asked = places / self.steps
            every, without = self._every.near_many(asked), self._every_infeasible.weights_near_many(asked)
            costs, support = _costs_and_support(every, without)
            return costs.reshape(shape), support.reshape(shape)

    def preferred(
        self, costs: Array, support: Array, chances: Sequence[float] | None
    ) -> tuple[Array, NDArray[np.bool]]:
        """What sheets of such costs are chosen by, the less the better, and whether it is believed.

        That is the cost, believed from a support of SUPPORT on. Over more than NEAR_AXES axes, where `chances` are
        known, the probability of each gait to be the best, it is the cost over the gait's, believed from TRIED on.
        """
        if chances is None or not self.is_wide:
            return costs, support >= SUPPORT
        of_sheets = np.array([chances[sheet.gait] for sheet in self.sheets], dtype=float)
        return costs / np.maximum(of_sheets, LEAST_CHANCE), support >= TRIED

    def by_cost(self, place: Array, chances: Sequence[float] | None = None) -> list[int]:
        """The sheets with a node within reach of a place; of equal ones the first, over many axes of those ALIKE.

        First those that are believed, in the order that they are `preferred`. Then the others, by support in
        hundredths: where a gait lacks nodes it costs more than it seems, or has no motion.
        """
        costs, support = self.costs(place)
        by, believed = self.preferred(costs, support, chances)
        if self.is_wide:
            with np.errstate(invalid="ignore"):
                by = np.rint(np.log(by) / ALIKE)
        doubted = np.where(believed, 0.0, 1 - np.floor(100 * support) / 100)
        return [sheet for sheet in np.lexsort((by, doubted)).tolist() if support[sheet] > 0]

    def ranked(self, place: Array, chances: Sequence[float] | None = None) -> list[int]:
        """The first sheet of each gait, in the order of `by_cost`."""
        best: dict[int, int] = {}
        for sheet in self.by_cost(place, chances):
            best.setdefault(self.sheets[sheet].gait, sheet)
        return list(best.values())

    def predict(self, sheet: int, place: Array) -> Prediction | None:
        """The start of a sheet at a place; None where no node is within reach."""
        nodes, chosen = self._nodes[sheet], self.sheets[sheet]
        near, offsets, distances = nodes.around(place)
        within = int(np.searchsorted(distances, REACH))
        if not within:
            return None
        near, offsets = near[:within], offsets[:within]
        coordinates, tangents = nodes.coordinates(near), nodes.tangents(near)
        moved = coordinates - _along(tangents, offsets)
        alike = np.linalg.norm(moved - moved[0], axis=1) <= chosen.tear
        own = Near(
            count=1,
            owner=np.zeros(within, dtype=np.intp),
            weights=np.where(alike, weights_of(distances[:within]), 0.0),
            offsets=list(offsets.T),
            logs=nodes.logs[near],
            slopes=list(nodes.slopes[near].T),
        )
        weights = own.agreed()
        log = float(np.clip(own.blended(weights)[0], *self._not_far_off(own.logs[alike])))
        weights /= weights.sum()
        halfway = (offsets + weights @ offsets) / 2
        return self._prediction(chosen, log, weights @ (coordinates - _along(tangents, halfway)))

    def nearest(self, sheet: int, place: Array, count: int) -> list[Prediction]:
        """First-order predictions of the `count` nodes of a sheet nearest to a place, nearest first.

        Nodes out of reach are taken as they are: so far no tangent leads.
        """
        nodes, chosen = self._nodes[sheet], self.sheets[sheet]
        near, offsets, distances = nodes.around(place, count)
        offsets = np.where(distances[:, None] < REACH, offsets, 0.0)
        logs = nodes.logs[near] - (offsets * nodes.slopes[near]).sum(axis=1)
        logs = [np.clip(log, *self._not_far_off(own)) for log, own in zip(logs, nodes.logs[near], strict=True)]
        moved = nodes.coordinates(near) - _along(nodes.tangents(near), offsets)
        return [self._prediction(chosen, float(log), one) for log, one in zip(logs, moved, strict=True)]

    def least_costs(self, place: Array) -> Array:
        """What each sheet may cost at a place at the least, the problem's; infinite below a support of HARDLY_TRIED.

        A prediction is as good as its nodes agree: what it may be off by is DOUBT times the standard deviation, with
        the nodes' weights by distance alone, of the logarithms that they promise, each by its whole tangent. Over more
        than NEAR_AXES axes a cost is at most MOST_BELOW times below its prediction. Below a support of TRIED the
        prediction counts HARDLY times.
        """
        (costs, support), count = self.costs(place), len(self.sheets)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            near = self._every.near(place / self.steps)
            total = np.bincount(near.owner, near.weights, count)
            mean = np.bincount(near.owner, near.weights * near.promises, count) / total
            squares = np.bincount(near.owner, near.weights * (near.promises - mean[near.owner]) ** 2, count)
            doubted = costs * np.exp(-DOUBT * np.sqrt(squares / total))
            if self.is_wide:
                doubted = np.maximum(doubted, costs / MOST_BELOW)
            least = np.where(support < TRIED, HARDLY * costs, doubted)
            return np.where(support < HARDLY_TRIED, np.inf, least)

    def _not_far_off(self, logs: Array) -> tuple[float, float]:
        """Least and largest logarithm of a start's cost, by rule 5, from its nodes'."""
        off = MOST_OFF if self.is_wide else np.inf
        return float(np.min(logs)) - off, float(np.max(logs)) + off

    def _prediction(self, sheet: Sheet, log: float, coordinates: Array) -> Prediction:
        cost = float(np.exp(np.clip(log, -LARGEST_LOG, LARGEST_LOG)))
        numbers = sheet.mean + coordinates @ sheet.modes
        is_encoded = len(numbers) == sheet.space.size
        return Prediction(cost, numbers if is_encoded else Condenser(sheet.space, self.barrier).expanded(numbers))

    @cached_property
    def _nodes(self) -> list[_Nodes]:
        return [_Nodes(sheet, self.steps) for sheet in self.sheets]

    @cached_property
    def _every(self) -> EveryNode:
        return EveryNode([(nodes.places, nodes.logs, nodes.slopes) for nodes in self._nodes], len(self.axes))

    @cached_property
    def _every_infeasible(self) -> EveryPlace:
        return EveryPlace([sheet.infeasible / self.steps for sheet in self.sheets], len(self.axes))


class _Nodes:
    """A sheet's nodes with lengths in steps: places [n, a], logarithms of costs [n] and their slopes [n, a]."""

    def __init__(self, sheet: Sheet, steps: Array) -> None:
        self._sheet, self._steps = sheet, steps
        self.places, self.logs, self.slopes = sheet.tasks / steps, np.log(sheet.costs), sheet.slopes * steps

    def around(self, place: Array, count: int | None = None) -> tuple[NDArray[np.intp], Array, Array]:
        """`count` or all nodes, nearest to a place [a] first: numbers [n], offsets from it [n, a] and distances [n]."""
        with np.errstate(over="ignore"):  # however far a task lies beyond
            offsets = self.places - place / self._steps
            distances = np.hypot.reduce(offsets, axis=1)
        order = np.argsort(distances, kind="stable")[:count]
        return order, offsets[order], distances[order]

    def coordinates(self, near: NDArray[np.intp]) -> Array:
        return self._sheet.coordinates[near].astype(np.float64)

    def tangents(self, near: NDArray[np.intp]) -> Array:
        """[near, a, k], a step along each axis."""
        return self._sheet.tangents[near] * self._steps[:, None]


def _along(tangents: Array, offsets: Array) -> Array:
    """How much coordinates [n, k] change along offsets [n, a] by tangents [n, a, k]."""
    moved: Array = (offsets[:, None, :] @ tangents)[:, 0]
    return moved


def _costs_and_support(near: Near, without: Array) -> tuple[Array, Array]:
    """Of each sheet, by its nodes near a place and the weights of its places near it that have no motion."""
    total, lean = np.bincount(near.owner, near.weights, near.count), np.zeros(near.count)
    for offset in near.offsets:
        mean = np.bincount(near.owner, near.weights * offset, near.count) / total
        lean += mean * mean
    mixed = near.blended(near.agreed())
    costs = np.exp(np.clip(mixed, -LARGEST_LOG, LARGEST_LOG))
    return costs, np.where(total > 0, (1 - np.sqrt(lean) / REACH) * total / (total + without), 0.0)
