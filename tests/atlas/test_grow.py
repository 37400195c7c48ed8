"""Growing nodes: each is a checked optimum, they cover what is worth it, and better motions spread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from tiny_map import GALLOP, SOLVED_AT, WALKING, solution_of, solved_at, tiny_domain, tiny_problem

from gaitflow.atlas.grow import BARRIER, COMPETITIVE, FAR, REFINE, Grown, Node, Place, _Growth, finer, grow
from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.search.solution import Solution
from gaitflow.solvers.point import Point

GALLOPS = Pattern.from_text(SOLVED_AT[GALLOP][0])


def box(speed: float, duration: float) -> bool:
    """5 by 4 nodes around the task that the gallop was solved at."""
    return 1.05 < speed < 1.55 and 0.5 < duration < 0.75


def seed(gait: str = GALLOP) -> Solution:
    return solution_of(*SOLVED_AT[gait], solved_at(gait))


@pytest.fixture(scope="module")
def boxed() -> Grown:
    return grow(tiny_problem(), [GALLOPS], [seed()], box)


def test_axes_are_refined_between_the_maps_tasks() -> None:
    assert finer((0.1, 0.5, 0.7)) == (0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.6, 0.65, 0.7)
    assert len(finer((0.1, 0.5, 0.7))) == 2 * REFINE + 1
    assert finer((0.3,)) == (0.3, 1.3), "blending wants two; no node lies at the second"


def test_every_node_is_an_optimum_that_passes_the_check(grown: Grown) -> None:
    problem = tiny_problem()
    data, checked = problem.scenario.as_data(), 0
    for pattern, method, nodes in zip(grown.patterns, grown.methods, grown.nodes, strict=True):
        for (i, j), node in sorted(nodes.items())[::5]:
            task = np.array([grown.speeds[i], grown.cycle_durations[j]])
            outcome = method.follow(task, node.point, node.cost, BARRIER, 30)
            assert outcome.converged, (pattern.text, task)
            assert outcome.cost == pytest.approx(node.cost, rel=1e-6)
            trajectory = problem.layout.unpack(outcome.w, task[1])
            assert check.worst(data, trajectory, *task, pattern.text) <= check.FEASIBLE
            checked += 1
    assert checked > 50


def test_nodes_lie_on_the_central_path(boxed: Grown) -> None:
    (method,), (nodes,) = boxed.methods, boxed.nodes
    for (i, j), node in nodes.items():
        task = np.array([boxed.speeds[i], boxed.cycle_durations[j]])
        assert method.centre(task, node.point, node.cost, BARRIER, 1).converged


def test_all_that_is_inside_around_a_seed_is_covered(boxed: Grown) -> None:
    speeds, durations = enumerate(boxed.speeds), list(enumerate(boxed.cycle_durations))
    expected = {(i, j) for i, v in speeds for j, t in durations if box(v, t)}
    assert set(boxed.nodes[0]) == expected
    assert len(expected) == 5 * 4
    assert boxed.solves >= len(expected)


def test_equal_arguments_give_equal_nodes(boxed: Grown) -> None:
    again = grow(tiny_problem(), [GALLOPS], [seed()], box)
    assert again.solves == boxed.solves
    assert list(again.nodes[0]) == list(boxed.nodes[0])
    for place, node in boxed.nodes[0].items():
        assert again.nodes[0][place].cost == node.cost
        for name in ("free", "rows", "lower", "upper"):
            np.testing.assert_array_equal(getattr(again.nodes[0][place].point, name), getattr(node.point, name))


def test_growing_tells_how_many_nodes_there_are() -> None:
    heard: list[int] = []
    found = grow(tiny_problem(), [GALLOPS], [seed()], box, heard.append)
    assert heard == sorted(heard)
    assert heard[0] > 1 and heard[-1] == len(found.nodes[0])


def test_a_gait_spreads_only_from_where_it_is_nearly_the_cheapest(grown: Grown) -> None:
    best = {
        place: min(nodes[place].cost for nodes in grown.nodes if place in nodes)
        for nodes in grown.nodes
        for place in nodes
    }
    domain, outside = tiny_domain(), 0
    for nodes in grown.nodes:
        for (i, j), node in nodes.items():
            assert domain.contains(grown.speeds[i], grown.cycle_durations[j])
            outside += node.cost > COMPETITIVE * best[i, j]
            around = [nodes[near] for near in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)) if near in nodes]
            assert around, "every node has the neighbour that it was solved from"
    assert 0 < outside < 0.5 * sum(map(len, grown.nodes)), "it is followed a step further, to know where it ends"
    assert len(grown.nodes[0]) < len(best), "walking ends before the domain does"


@pytest.mark.parametrize(
    "spoil",
    [
        lambda one: replace(one, split="held_out"),
        lambda one: replace(one, status="failed"),
        lambda one: replace(one, pattern="0111/1101"),
        lambda one: replace(one, trajectory=None),
        lambda one: replace(one, multipliers=None),
    ],
)
def test_what_is_no_solved_task_of_the_grid_is_no_seed(spoil: Callable[[Solution], Solution]) -> None:
    found = grow(tiny_problem(), [GALLOPS], [spoil(seed())], box)
    assert found.nodes == ({},) and found.solves == 0


def test_the_order_of_solutions_does_not_matter(boxed: Grown) -> None:
    patterns = [Pattern.from_text(SOLVED_AT[gait][0]) for gait in (WALKING, GALLOP)]
    solutions = [seed(WALKING), seed(GALLOP)]
    one, other = (grow(tiny_problem(), patterns, each, box) for each in (solutions, solutions[::-1]))
    assert [list(nodes) for nodes in one.nodes] == [list(nodes) for nodes in other.nodes]
    assert one.solves == other.solves
    costs = [node.cost for node in one.nodes[1].values()]
    assert costs == pytest.approx([boxed.nodes[0][place].cost for place in one.nodes[1]], rel=1e-6)


def node(motion: float, cost: float) -> Node:
    return Node(cost, Point(np.full(3, motion), np.zeros(1), np.zeros(3), np.zeros(3)))


def scripted(monkeypatch: pytest.MonkeyPatch, dearer: float, apart: float) -> _Growth:
    """A growth over the box whose solves keep the motion they start at: 0 costs 1, the other `dearer`."""
    growth = _Growth(tiny_problem(), [GALLOPS], box)

    def solved(self: _Growth, gait: int, place: Place, start: Node) -> Node:
        self.solves += 1
        motion = float(start.point.free[0])
        return node(motion, dearer if motion else 1.0)

    monkeypatch.setattr(_Growth, "_solved", solved)
    inside = [(i, j) for i, v in enumerate(growth.speeds) for j, t in enumerate(growth.durations) if box(v, t)]
    growth._keep(0, inside[0], node(apart, dearer))
    growth._keep(0, inside[-1], node(0.0, 1.0))
    return growth


def test_a_better_motion_of_a_neighbour_replaces_a_worse_one(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = scripted(monkeypatch, dearer=1.1, apart=2 * FAR)
    growth.spread(lambda nodes: None)
    assert len(growth.nodes[0]) >= 15
    assert {found.cost for found in growth.nodes[0].values()} == {1.0}


def test_a_gain_too_small_to_tell_replaces_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = scripted(monkeypatch, dearer=1.00001, apart=2 * FAR)
    growth.spread(lambda nodes: None)
    assert {found.cost for found in growth.nodes[0].values()} == {1.0, 1.00001}


def test_the_same_motion_is_not_solved_again_from_every_side(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = scripted(monkeypatch, dearer=1.1, apart=0.1 * FAR)
    growth.spread(lambda nodes: None)
    assert growth.solves == len(growth.nodes[0]) - 2, "one solve a node, beside the two that were there"
