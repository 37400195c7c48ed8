"""Borders of gaits: nodes on one side, places without a motion on the other, close together."""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from limited import Limited

from gaitflow.atlas import border
from gaitflow.atlas.border import NARROW, find_borders, reconsider
from gaitflow.atlas.compress import cost_atlas
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import Place
from gaitflow.runtime.atlas import SUPPORT

GAITS = [0, 1]


def limited(grown: Growth, feasible: Callable[[Place], bool]) -> Growth:
    """A growth of one's own, whose first pattern has motions where `feasible` says so."""
    own, first = copy.copy(grown), dict(grown.nodes[0])
    own.solver = Limited(grown.solver, next(iter(first.values())), feasible)  # type: ignore[assignment]
    own.nodes = [{place: node for place, node in first.items() if feasible(place)}, dict(grown.nodes[1])]
    own.infeasible, own.best = [set(), set()], dict(grown.best)
    own._fringe = deque()
    return own


def away(growth: Growth, one: Place, other: Place) -> float:
    return float(np.linalg.norm((np.array(one) - other) / growth.steps))


@given(share=st.floats(0.05, 0.95), lean=st.floats(-0.3, 0.3))
def test_a_border_is_known_from_both_sides(grown: Growth, share: float, lean: float) -> None:
    speeds, durations = grown.grid
    limit, middle = speeds[0] + share * (speeds[-1] - speeds[0]), np.mean(durations)

    def feasible(place: Place) -> bool:
        return place[0] <= limit + lean * (place[1] - middle)

    growth = limited(grown, feasible)
    beyond = [place for place in grown.nodes[0] if not feasible(place)]
    if not beyond or not growth.nodes[0]:
        return
    assert find_borders(growth, [(0, place) for place in beyond])
    assert set(beyond) <= growth.infeasible[0]
    assert not any(map(feasible, growth.infeasible[0])), "no place with a motion is taken to have none"
    for place in beyond:
        nearest = min(growth.nodes[0], key=lambda node: away(growth, node, place))
        other = min(growth.infeasible[0], key=lambda each: away(growth, each, nearest))
        assert feasible(nearest)
        assert away(growth, nearest, other) <= NARROW * (1 + 1e-6), "the border lies between two places close together"


def test_a_gait_is_not_believed_beyond_its_border(grown: Growth) -> None:
    speeds, durations = grown.grid
    limit = (speeds[0] + speeds[-1]) / 2

    growth = limited(grown, lambda place: place[0] <= limit)
    asked = [(limit + side * growth.steps[0] / 4, durations[0]) for side in (-1, 1)]
    find_borders(growth, [(0, place) for place in grown.nodes[0] if place[0] > limit])
    supports = [cost_atlas(growth, GAITS).costs(np.array(place))[1][0] for place in asked]
    assert supports[0] >= SUPPORT > supports[1]


def test_many_places_beyond_a_border_do_not_move_it(grown: Growth) -> None:
    speeds, durations = grown.grid
    limit = (speeds[0] + speeds[-1]) / 2
    growth = limited(grown, lambda place: place[0] <= limit)
    find_borders(growth, [(0, place) for place in grown.nodes[0] if place[0] > limit])
    inside = np.array((limit - growth.steps[0] / 4, durations[0]))
    few = cost_atlas(growth, GAITS).costs(inside)[1][0]
    for share in np.linspace(0.1, 0.4, 20):
        growth.give_up(0, (limit + share * growth.steps[0], durations[0]))
    many = cost_atlas(growth, GAITS).costs(inside)[1][0]
    assert few >= SUPPORT and many >= SUPPORT


def test_what_is_known_is_not_looked_for(grown: Growth) -> None:
    growth = limited(grown, lambda place: True)
    assert not find_borders(growth, [(0, place) for place in growth.nodes[0]])
    assert not growth.solver.asked  # type: ignore[attr-defined]
    growth.nodes[0] = {}
    assert not find_borders(growth, [(0, next(iter(grown.nodes[0])))]), "a gait without a node has no border"


def test_a_node_that_is_found_later_replaces_the_place_without_one(grown: Growth) -> None:
    growth = limited(grown, lambda place: True)
    place, node = growth.nodes[0].popitem()
    growth.give_up(0, place)
    assert growth.infeasible[0] == {place}
    assert growth.keep(0, node)
    assert not growth.infeasible[0]
    growth.give_up(0, place)
    assert not growth.infeasible[0], "where there is a node there is a motion"
    growth.give_up(0, (99.0, 9.0))
    assert not growth.infeasible[0], "beyond the domain nobody asks"


def test_borders_are_in_the_atlas(grown: Growth) -> None:
    growth = limited(grown, lambda place: True)
    place = next(iter(growth.nodes[0]))
    del growth.nodes[0][place]
    growth.give_up(0, place)
    sheets = cost_atlas(growth, GAITS).sheets
    assert sheets[0].infeasible.tolist() == [list(place)]
    assert sheets[1].infeasible.shape == (0, 2)


@pytest.mark.parametrize(("is_wide", "halving"), [(False, 2), (True, 5)])
def test_a_place_is_tried_from_two_nodes_and_the_nominal_start_and_a_halving_from_the_nearest_node(
    grown: Growth, monkeypatch: pytest.MonkeyPatch, is_wide: bool, halving: int
) -> None:
    """Quickly and carefully from each node; over many axes the halving is tried from all of them as well."""
    monkeypatch.setattr(Growth, "is_wide", is_wide)
    speeds, durations = grown.grid
    growth = limited(grown, lambda place: place[0] <= speeds[0])
    place = (speeds[0] + growth.steps[0], durations[0])
    find_borders(growth, [(0, place)])
    asked = growth.solver.asked  # type: ignore[attr-defined]
    assert asked.count(place) == 5
    assert {asked.count(near) for near in growth.infeasible[0] - {place}} == {halving}


def test_the_nominal_start_finds_what_no_node_leads_to(grown: Growth, monkeypatch: pytest.MonkeyPatch) -> None:
    speeds, durations = grown.grid
    place, far = (speeds[1], durations[1]), grown.nodes[0][speeds[0], durations[0]]
    lost = replace(far, point=np.full_like(far.point, 50.0))
    own = copy.copy(grown)
    own.nodes, own.infeasible = [{lost.place: lost}, {}], [set(), set()]
    own.best, own._fringe = dict(grown.best), deque()
    monkeypatch.setattr(border, "NARROW", 9.0)  # steps: no place between is looked at
    find_borders(own, [(0, place)])
    assert own.nodes[0][place].cost == pytest.approx(grown.nodes[0][place].cost, rel=1e-6)
    assert not own.infeasible[0]


def test_what_was_given_up_too_early_is_found_when_it_is_tried_again(grown: Growth) -> None:
    speeds, durations = grown.grid
    known = (speeds[0], durations[0])
    growth = limited(grown, lambda place: place == known)
    find_borders(growth, [(0, (speed, durations[0])) for speed in speeds[1:3]])
    given_up = set(growth.infeasible[0])
    assert reconsider(growth) == 0 and growth.infeasible[0] == given_up
    growth.solver._feasible = lambda place: place[0] < speeds[2]  # type: ignore[attr-defined]
    found = {place for place in given_up if place[0] < speeds[2]}
    assert found and reconsider(growth) >= len(found)
    assert found <= set(growth.nodes[0]) and not found & growth.infeasible[0]
    assert given_up - found <= growth.infeasible[0], "where there is no motion there is none"
