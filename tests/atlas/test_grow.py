"""Growing nodes: each is an optimum, they cover what is worth it, and better motions spread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from tiny_map import GALLOP, SOLVED_AT, WALKING, solution_of, solved_at, task_of, tiny_domain, tiny_growth, tiny_problem

from gaitflow.atlas import grow as grow_module
from gaitflow.atlas.grow import COMPETITIVE, Growth, grow
from gaitflow.atlas.node import BARRIER, Node, NodeSolver, Place
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.runtime.atlas import Prediction
from gaitflow.search.solution import Solution

GALLOPS = Pattern.from_text(SOLVED_AT[GALLOP][0])


def seed(gait: str = GALLOP) -> Solution:
    pattern, speed, cycle = SOLVED_AT[gait]
    return solution_of(pattern, task_of(speed, cycle), solved_at(gait))


def box() -> Domain:
    """3 by 2 tasks around the one that the gallop was solved at."""
    whole = tiny_domain()
    axes = {"speed": whole.axes["speed"][2:5], "cycle_duration": whole.axes["cycle_duration"][0:2]}
    return Domain(axes, np.ones((3, 2), dtype=bool))


@pytest.fixture(scope="module")
def boxed() -> Growth:
    return grow(tiny_problem(), [GALLOPS], [seed()], box())


def test_every_node_is_an_optimum(grown: Growth) -> None:
    checked = 0
    for method, nodes in zip(grown.solver.methods, grown.nodes, strict=True):
        for place, node in nodes.items():
            start = method.space.decode(node.point)
            outcome = method.follow(grown.solver.parameters(place), start, node.cost, BARRIER, 30)
            assert outcome.converged
            assert outcome.cost == pytest.approx(node.cost, rel=1e-5)
            checked += 1
    assert checked > 20


def test_all_that_is_inside_around_a_seed_is_covered(boxed: Growth) -> None:
    assert set(boxed.nodes[0]) == {(v, t) for v in boxed.grid[0] for t in boxed.grid[1]}
    assert boxed.solver.solves >= 6


def test_no_node_lies_where_the_domain_is_not(grown: Growth) -> None:
    hole = (tiny_domain().axes["speed"][-1], tiny_domain().axes["cycle_duration"][0])
    assert not grown.inside(hole)
    assert all(grown.inside(place) for nodes in grown.nodes for place in nodes)


def test_equal_arguments_give_equal_nodes(boxed: Growth) -> None:
    again = grow(tiny_problem(), [GALLOPS], [seed()], box())
    assert again.solver.solves == boxed.solver.solves
    assert list(again.nodes[0]) == list(boxed.nodes[0])
    for place, node in boxed.nodes[0].items():
        assert again.nodes[0][place].cost == node.cost
        np.testing.assert_array_equal(again.nodes[0][place].point, node.point)
        np.testing.assert_array_equal(again.nodes[0][place].tangents, node.tangents)


def test_the_nearest_nodes_come_first(boxed: Growth) -> None:
    (v, w, _), (t, u) = boxed.grid
    place = (0.6 * v + 0.4 * w, t)
    found = boxed.nearest(0, place, 3)
    for one, (speed, duration) in zip(found, [(v, t), (w, t), (v, u)], strict=True):
        expected = boxed.nodes[0][speed, duration].moved(place)
        assert one.cost == expected.cost
        np.testing.assert_array_equal(one.point, expected.point)


def test_over_many_axes_what_is_predicted_dear_is_not_solved(grown: Growth, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Growth, "is_wide", True)
    monkeypatch.setattr(grow_module, "COMPETITIVE_WIDE", COMPETITIVE)
    monkeypatch.setattr(grow_module, "HOPELESS", 1.0)
    thrifty = tiny_growth.__wrapped__()  # not the one that is kept
    nodes, all_nodes = (sum(map(len, each.nodes)) for each in (thrifty, grown))
    assert nodes < 0.9 * all_nodes and thrifty.solver.solves < grown.solver.solves
    assert thrifty.best == pytest.approx(grown.best, rel=1e-3), "what is cheapest anywhere is found all the same"


@pytest.mark.parametrize(("is_wide", "most"), [(False, "MOST_IN_VAIN"), (True, "MOST_IN_VAIN_WIDE")])
def test_a_gait_is_given_up_at_a_place_after_attempts_in_vain(
    grown: Growth, monkeypatch: pytest.MonkeyPatch, is_wide: bool, most: str
) -> None:
    monkeypatch.setattr(Growth, "is_wide", is_wide)
    monkeypatch.setattr(grow_module, "COMPETITIVE_WIDE", COMPETITIVE)
    monkeypatch.setattr(grow_module, "HOPELESS", np.inf)
    monkeypatch.setattr(grow_module, most, 1)
    thrifty = tiny_growth.__wrapped__()
    assert thrifty.solver.solves < grown.solver.solves
    assert thrifty.best == pytest.approx(grown.best, rel=1e-3), "what is cheapest anywhere is found all the same"


def test_growing_tells_how_many_nodes_there_are() -> None:
    heard: list[int] = []
    found = grow(tiny_problem(), [GALLOPS], [seed()], box(), heard.append)
    assert heard[0] == 1 and heard == sorted(heard) and heard[-1] == len(found.nodes[0])


def test_a_gait_spreads_only_from_where_it_is_nearly_the_cheapest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grow_module, "COMPETITIVE", 1.0)
    patterns, seeds = [Pattern.from_text(SOLVED_AT[gait][0]) for gait in (WALKING, GALLOP)], [seed(WALKING), seed()]
    found = grow(tiny_problem(), patterns, seeds, tiny_domain())
    dearer = [node for nodes in found.nodes for place, node in nodes.items() if node.cost > found.best[place]]
    assert dearer, "it is followed a step further, to know where it ends"
    assert sum(map(len, found.nodes)) < 1.5 * len(found.best), "where both gaits are known is a band between them"


@pytest.mark.parametrize(
    "spoil",
    [
        lambda one: replace(one, task=replace(one.task, split="held_out")),
        lambda one: replace(one, task=one.task.replaced(speed=0.1)),  # not inside
        lambda one: replace(one, status="failed"),
        lambda one: replace(one, pattern="0111/1101"),
        lambda one: replace(one, trajectory=None),
        lambda one: replace(one, multipliers=None),
    ],
)
def test_what_is_no_solved_task_of_the_grid_is_no_seed(spoil: Callable[[Solution], Solution]) -> None:
    found = grow(tiny_problem(), [GALLOPS], [spoil(seed())], box())
    assert found.nodes == [{}] and found.solver.solves == 0


def test_a_gait_that_is_far_from_the_cheapest_is_not_seeded() -> None:
    rival = replace(seed(), pattern="0001/0100", cost=seed().cost / (COMPETITIVE + 0.01))
    assert grow(tiny_problem(), [GALLOPS], [seed(), rival], box()).nodes == [{}]


def test_the_order_of_solutions_does_not_matter() -> None:
    patterns = [Pattern.from_text(SOLVED_AT[gait][0]) for gait in (WALKING, GALLOP)]
    solutions = [seed(WALKING), seed(GALLOP)]
    one, other = (grow(tiny_problem(), patterns, each, tiny_domain()) for each in (solutions, solutions[::-1]))
    assert [list(nodes) for nodes in one.nodes] == [list(nodes) for nodes in other.nodes]
    assert one.solver.solves == other.solver.solves


def node(place: Place, motion: float, cost: float) -> Node:
    return Node(place, cost, np.zeros(2), np.full(1, motion), np.zeros((2, 1)))


def scripted(monkeypatch: pytest.MonkeyPatch, dearer: float) -> Growth:
    """A growth over the box whose solves keep the motion they start at: 0 costs 1, the other `dearer`."""
    growth = Growth(tiny_problem(), NodeSolver(tiny_problem(), [GALLOPS]), box())

    def solved(self: NodeSolver, sheet: int, place: Place, start: Prediction) -> Node:
        self.solves += 1
        motion = float(start.point[0])
        return node(place, motion, dearer if motion else 1.0)

    monkeypatch.setattr(NodeSolver, "node", solved)
    places = [(v, t) for v in growth.grid[0] for t in growth.grid[1]]
    growth.keep(0, node(places[0], 1.0, dearer))
    growth.keep(0, node(places[-1], 0.0, 1.0))
    growth.spread()
    return growth


def test_a_better_motion_of_a_neighbour_replaces_a_worse_one(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = scripted(monkeypatch, dearer=1.1)
    assert len(growth.nodes[0]) == 6
    assert {found.cost for found in growth.nodes[0].values()} == {1.0}


def test_a_cheaper_prediction_of_the_same_motion_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grow_module, "APART", 2.0)
    growth = scripted(monkeypatch, dearer=1.1)
    assert growth.solver.solves == len(growth.nodes[0]) - 2


def test_a_gain_too_small_to_tell_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = scripted(monkeypatch, dearer=1.001)
    assert {found.cost for found in growth.nodes[0].values()} == {1.0, 1.001}
    assert growth.solver.solves == len(growth.nodes[0]) - 2, "one solve a node, beside the two that were there"


def test_a_seed_off_the_grid_spreads_to_the_corners_of_its_cell() -> None:
    _, speed, cycle = SOLVED_AT[GALLOP]
    off = (speed + 0.03, cycle - 0.01)
    start = grow(tiny_problem(), [GALLOPS], [seed()], box()).nodes[0][speed, box().axes["cycle_duration"][1]]
    solved = solved_at(GALLOP)
    growth = Growth(tiny_problem(), NodeSolver(tiny_problem(), [GALLOPS]), box())
    node = growth.solver.node(0, off, start.moved(off))
    assert node is not None and solved.feasible
    growth.keep(0, node)
    assert not growth.reached.feasible.any(), "a node off the grid is no task of it"
    growth.spread()
    assert set(growth.nodes[0]) - {off} == {(v, t) for v in growth.grid[0] for t in growth.grid[1]}
    assert growth.reached.feasible.all()


def test_patterns_that_come_later_have_nodes_of_their_own(boxed: Growth) -> None:
    later = Growth(tiny_problem(), NodeSolver(tiny_problem(), []), box())
    later.sow([seed()])
    assert not later.nodes and later.best, "what is known of costs does not wait for a pattern"
    later.extend([GALLOPS])
    later.sow([seed()])
    later.spread()
    assert set(later.nodes[0]) == set(boxed.nodes[0])
    assert len(later.nearest(0, (0.9, 0.5), 2)) == 2
