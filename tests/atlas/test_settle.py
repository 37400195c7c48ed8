"""Where an atlas picks another gait than the search found best, nodes are added until it does not."""

from __future__ import annotations

import copy
from collections import deque

import numpy as np
import pytest

from gaitflow.atlas.compress import cost_atlas
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import Place
from gaitflow.atlas.settle import mistaken, settle

GAITS = [0, 1]


@pytest.fixture
def growth(grown: Growth) -> Growth:
    """A growth of one's own, of the same nodes."""
    own = copy.copy(grown)
    own.nodes = [dict(nodes) for nodes in grown.nodes]
    own.infeasible = [set() for _ in grown.nodes]
    own.best = dict(grown.best)
    own._fringe = deque()
    return own


def true_costs(growth: Growth) -> dict[Place, dict[int, float]]:
    """The excess of both gaits wherever both have a node."""
    shared = sorted(set(growth.nodes[0]) & set(growth.nodes[1]))
    costs = {place: [nodes[place].cost for nodes in growth.nodes] for place in shared}
    return {place: {gait: cost / min(each) - 1 for gait, cost in enumerate(each)} for place, each in costs.items()}


def test_an_atlas_with_a_node_at_every_known_task_is_settled(growth: Growth) -> None:
    before = growth.solver.solves
    assert settle(growth, GAITS, true_costs(growth), 1e-3) == 0
    assert growth.solver.solves == before, "nothing had to be solved"


def test_a_gait_that_lost_its_nodes_gets_them_back(growth: Growth) -> None:
    known = true_costs(growth)
    place = max(known, key=lambda each: max(known[each].values()))  # where one of the gaits is dearest
    best = min(known[place], key=lambda gait: known[place][gait])
    steps = growth.steps
    for other in list(growth.nodes[best]):
        if np.linalg.norm((np.array(other) - place) / steps) < 1.6:
            del growth.nodes[best][other]
    only = {place: known[place]}
    assert mistaken(cost_atlas(growth, GAITS), place, only[place], 1e-3), "the dear gait is all that is known here"
    told: list[str] = []
    assert settle(growth, GAITS, only, 1e-3, told.append) == 0
    assert growth.nodes[best][place].cost == pytest.approx(min(growth.best[place], growth.nodes[best][place].cost))
    assert told[0] == "other gaits than the search's at 1 of 1 tasks, round 1"


def test_nodes_of_several_places_are_solved_side_by_side(growth: Growth, monkeypatch: pytest.MonkeyPatch) -> None:
    known = true_costs(growth)
    for gait, places in enumerate(growth.nodes):
        for place in list(places):
            if place in known and known[place][gait] == 0:
                del places[place]
    wrong = {place: each for place, each in known.items() if mistaken(cost_atlas(growth, GAITS), place, each, 1e-3)}
    sizes, solve = list[int](), growth.solver.nodes
    monkeypatch.setattr(growth.solver, "nodes", lambda requests: sizes.append(len(requests)) or solve(requests))
    settle(growth, GAITS, wrong, 1e-3)
    assert len(wrong) > 1 and max(sizes) >= len(wrong)


def test_what_cannot_be_mended_is_counted(growth: Growth) -> None:
    place = next(iter(true_costs(growth)))
    picked = cost_atlas(growth, GAITS)
    gait = picked.sheets[picked.ranked(np.array(place))[0]].gait
    impossible = {place: {gait: 1.0, 1 - gait: 0.0}}  # the search says otherwise, whatever the nodes cost
    assert settle(growth, GAITS, impossible, 1e-3) == 1


def test_a_place_of_which_nothing_is_known_is_no_mistake(growth: Growth) -> None:
    atlas = cost_atlas(growth, GAITS)
    assert mistaken(atlas, next(iter(growth.nodes[0])), {}, 1e-3) == ()
    assert mistaken(atlas, (99.0, 9.0), {0: 0.0}, 1e-3) == (), "the atlas knows no gait there"
