"""A node is a checked optimum; its slopes and tangents are derivatives, measured here by finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from tiny_map import GALLOP, SOLVED_AT, scenario_of, solved_at, tiny_problem

from gaitflow.atlas.node import BARRIER, Node, NodeSolver
from gaitflow.config.scenario import Range
from gaitflow.core import check
from gaitflow.core.gaits import Pattern
from gaitflow.problem import transcribe
from gaitflow.runtime.atlas import Prediction

PATTERN, SPEED, CYCLE = SOLVED_AT[GALLOP]
PLACE = (SPEED, CYCLE)
STEP = 1e-3


def made(solver: NodeSolver, start: Prediction, place: tuple[float, ...]) -> Node:
    node = solver.node(0, place, start)
    assert node is not None
    return node


@pytest.fixture(scope="module")
def solver() -> NodeSolver:
    return NodeSolver(tiny_problem(), [Pattern.from_text(PATTERN)])


@pytest.fixture(scope="module")
def node(solver: NodeSolver) -> Node:
    solved = solved_at(GALLOP)
    cost = solved.cost / tiny_problem().cost_scale
    start = solver.from_solution(0, solved.w, solved.multipliers.bounds, solved.multipliers.rows, cost)
    return made(solver, start, PLACE)


def test_a_node_is_the_solution_that_it_started_from(node: Node) -> None:
    assert node.cost * tiny_problem().cost_scale == pytest.approx(solved_at(GALLOP).cost, rel=1e-5)


def test_a_node_lies_on_the_central_path(solver: NodeSolver, node: Node) -> None:
    point = solver.methods[0].space.decode(node.point)
    assert solver.methods[0].centre(solver.parameters(PLACE), point, node.cost, BARRIER, 0).converged


def test_slopes_are_those_of_the_logarithm_of_the_cost(solver: NodeSolver, node: Node) -> None:
    for axis, slope in enumerate(node.slopes):
        low, high = (made(solver, node.moved(each), each).cost for each in _around(axis))
        assert slope == pytest.approx(np.log(high / low) / (2 * STEP), rel=1e-3)


def test_tangents_are_those_of_the_point_for_its_own_optimum(solver: NodeSolver, node: Node) -> None:
    for axis, tangent in enumerate(node.tangents):
        low, high = (made(solver, node.moved(each), each).point for each in _around(axis))
        measured = (high - low) / (2 * STEP)
        assert np.linalg.norm(tangent - measured) <= 0.02 * np.linalg.norm(measured)


def _around(axis: int) -> list[tuple[float, ...]]:
    return [tuple(x + side * STEP * (i == axis) for i, x in enumerate(PLACE)) for side in (-1, 1)]


def test_a_tangent_leads_nearer_to_another_task_than_the_node_itself(solver: NodeSolver, node: Node) -> None:
    place = (SPEED + 0.1, CYCLE - 0.05)
    there = made(solver, node.moved(place), place)
    moved = node.moved(place)
    free = slice(0, len(solver.methods[0].space.free))
    assert np.linalg.norm(moved.point[free] - there.point[free]) < 0.5 * np.linalg.norm(
        (node.point - there.point)[free]
    )
    assert moved.cost == pytest.approx(there.cost, rel=0.05)


def test_a_start_that_leads_nowhere_makes_no_node(solver: NodeSolver, node: Node) -> None:
    assert solver.node(0, (9.0, 0.3), Prediction(node.cost, node.point)) is None


def test_careful_steps_lead_further_to_the_same_node(solver: NodeSolver, node: Node) -> None:
    beside, far = (SPEED + 0.5, CYCLE), (SPEED + 1.0, CYCLE)
    careful = solver.careful_node(0, beside, node.moved(beside))
    assert careful is not None
    assert careful.cost == pytest.approx(made(solver, node.moved(beside), beside).cost, rel=1e-6)
    assert solver.node(0, far, node.moved(far)) is None
    there = solver.careful_node(0, far, node.moved(far))
    assert there is not None
    assert there.cost == pytest.approx(made(solver, careful.moved(far), far).cost, rel=1e-6)
    assert solver.careful_nodes([(0, (9.0, 0.3), Prediction(node.cost, node.point))]) == [None]


def test_a_motion_that_fails_the_check_makes_no_node(
    solver: NodeSolver, node: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(check, "worst", lambda *_: 1.0)
    assert solver.node(0, PLACE, Prediction(node.cost, node.point)) is None


def test_a_node_in_a_map_with_a_slope_knows_how_its_cost_rises_uphill() -> None:
    scenario = scenario_of(slope=Range(start=-10.0, stop=10.0, count=3))
    problem, place = transcribe(scenario), (SPEED, CYCLE, 0.0)
    solver = NodeSolver(problem, [Pattern.from_text(PATTERN)])
    solved = solved_at(GALLOP)  # of the problem without a slope: on level ground it is the same one
    cost = solved.cost / problem.cost_scale
    start = solver.from_solution(0, solved.w, solved.multipliers.bounds, solved.multipliers.rows, cost)
    uphill = (SPEED, CYCLE, 4.0)
    node = made(solver, made(solver, start, place).moved(uphill), uphill)
    assert node.slopes.shape == (3,) and node.tangents.shape == (3, len(node.point))
    steps = [(SPEED, CYCLE, 4.0 + side * 0.1) for side in (-1, 1)]
    low, high = (made(solver, node.moved(each), each).cost for each in steps)
    assert node.slopes[2] > 1e-3
    assert node.slopes[2] == pytest.approx(np.log(high / low) / 0.2, rel=1e-2)
