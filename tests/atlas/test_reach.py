"""Tasks of the grid that no gait has reached are tried again."""

from __future__ import annotations

import copy
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from limited import Limited

from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import Place
from gaitflow.atlas.reach import reach


def without(grown: Growth, places: set[Place], feasible: Callable[[Place], bool] | None) -> Growth:
    """A growth of one's own in which no gait has a node at some places; real, or with motions where `feasible`."""
    own = copy.copy(grown)
    own.nodes = [{place: node for place, node in nodes.items() if place not in places} for nodes in grown.nodes]
    own.infeasible, own.best = [set() for _ in grown.nodes], dict(grown.best)
    own._fringe, own._in_vain = deque(), Counter()
    if feasible is not None:
        own.solver = Limited(grown.solver, next(iter(grown.nodes[0].values())), feasible)  # type: ignore[assignment]
    return own


def test_a_task_that_every_gait_had_left_is_reached_by_a_solve(grown: Growth) -> None:
    lost = max(place for place in grown.nodes[0] if place[0] == grown.grid[0][1])
    growth = without(grown, {lost}, None)
    assert not growth.reached.contains(dict(zip(growth.domain.axes, lost, strict=True)))
    assert reach(growth) == 1
    assert (growth.reached.feasible == grown.domain.feasible).all()
    assert growth.nodes[0][lost].cost == pytest.approx(grown.nodes[0][lost].cost, rel=1e-6)


def test_what_is_reached_leads_on_to_what_lies_beyond(grown: Growth) -> None:
    speeds, durations = grown.grid
    known = (speeds[0], durations[0])
    growth = without(grown, set(grown.nodes[0]) | set(grown.nodes[1]), lambda place: True)
    growth.nodes[0] = {known: replace(grown.nodes[0][known], cost=1.0)}
    assert reach(growth) == grown.domain.feasible.sum() - 1
    assert (growth.reached.feasible == grown.domain.feasible).all()


def test_where_no_gait_has_a_motion_none_is_said_to_have_one(grown: Growth) -> None:
    speeds, durations = grown.grid
    hole = (speeds[-1], durations[-1])
    growth = without(grown, {hole}, lambda place: place != hole)
    assert reach(growth) == 0
    beside = {
        sheet for sheet, nodes in enumerate(growth.nodes) if any(near in nodes for near in growth.neighbours(hole))
    }
    assert beside and {sheet for sheet, places in enumerate(growth.infeasible) if hole in places} == beside
    assert not growth.reached.contains(dict(zip(growth.domain.axes, hole, strict=True)))


def test_nothing_is_solved_where_every_task_is_reached(grown: Growth) -> None:
    growth = without(grown, set(), lambda place: True)
    assert (growth.reached.feasible == grown.domain.feasible).all()
    assert reach(growth) == 0
    assert not growth.solver.asked  # type: ignore[attr-defined]


def test_a_task_far_from_every_node_is_not_tried(grown: Growth) -> None:
    """It would be tried from where nothing is known of it; what lies between is tried first."""
    speeds, durations = grown.grid
    known = (speeds[0], durations[0])
    growth = without(grown, set(grown.nodes[0]) | set(grown.nodes[1]), lambda place: place == known)
    growth.nodes[0] = {known: grown.nodes[0][known]}
    assert reach(growth) == 0
    asked = np.array(growth.solver.asked)  # type: ignore[attr-defined]
    assert (np.abs((asked - known) / growth.steps).sum(axis=1) <= 1.001).all()
