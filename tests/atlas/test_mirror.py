"""The image of a node is the node that a solve of the image's task would find."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gaitflow.atlas import fill
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.mirror import NodeImages
from gaitflow.atlas.node import Node, NodeSolver
from gaitflow.config.scenario import load_scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.dataset.mirror import MirrorImage
from gaitflow.problem import transcribe
from gaitflow.search import starts
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

SCENARIO = Path(__file__).parents[2] / "configs/scenarios/anymal-omni.yaml"
WALK = Pattern.from_text("0011/1100/1110/1001")
IMAGE = WALK.mirrored((1, 0, 3, 2))
PLACE = (0.4, 0.2, 0.5, 0.6)  # speed, lateral_speed, yaw_rate, cycle_duration
AXES = ("speed", "lateral_speed", "yaw_rate", "cycle_duration")


@cache
def _solver() -> NodeSolver:
    whole = load_scenario(SCENARIO)
    coarse = whole.transcription.model_copy(update={"knots_per_phase": 4})
    problem = transcribe(whole.model_copy(update={"transcription": coarse}))
    return NodeSolver(problem, [WALK, IMAGE])


@cache
def _node() -> Node:
    solver = _solver()
    problem, one = solver.problem, solver.problem.scenario
    task = one.tasks.space.task(dict(zip(AXES, PLACE, strict=True)))
    start = Start("nominal", starts.nominal(one.robot, problem.layout, task))
    attempt = FixedGaitSolver(problem, 20.0).solve(WALK, task, start)
    assert attempt.feasible
    known = attempt.multipliers
    w, cost = problem.layout.pack(attempt.trajectory, task.cycle_duration), attempt.cost / problem.cost_scale
    node = solver.node(0, PLACE, solver.from_solution(0, w, known.bounds, known.rows, cost))
    assert node is not None
    return node


def _images() -> NodeImages:
    return NodeImages(MirrorImage(_solver().problem.scenario), AXES)


def test_an_image_is_the_node_that_a_solve_there_finds() -> None:
    solver, node, images = _solver(), _node(), _images()
    spaces = [method.space for method in solver.methods]
    image = images.node(node, WALK, *spaces)
    assert image.place == (0.4, -0.2, -0.5, 0.6)
    solved = solver.node(1, image.place, image.moved(image.place))
    assert solved is not None and solved.cost == pytest.approx(image.cost, rel=1e-6)
    np.testing.assert_allclose(image.slopes, solved.slopes, rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(image.point, solved.point, atol=1e-2)
    near = (0.45, -0.25, -0.45, 0.62)
    one, other = (each.moved(near).point for each in (image, solved))
    assert np.abs(one - other).max() < 0.05 * np.abs(other).max()
    again = images.node(image, IMAGE, *spaces[::-1])
    np.testing.assert_array_equal(again.point, node.point)
    np.testing.assert_array_equal(again.tangents, node.tangents)
    assert again.place == node.place


def test_a_growth_stores_the_image_of_each_node_without_a_solve() -> None:
    ranges = {
        axis: (low, high) for axis, low, high in zip(AXES, (0.3, -0.3, -0.6, 0.5), (0.5, 0.3, 0.6, 0.7), strict=True)
    }
    growth = Growth(_solver().problem, _solver(), Domain(ranges, np.ones((2, 2, 2, 2), dtype=bool)), images=_images())
    before = _solver().solves
    assert growth.keep(0, _node())
    assert list(growth.nodes[0]) == [PLACE] and list(growth.nodes[1]) == [(0.4, -0.2, -0.5, 0.6)]
    assert _solver().solves == before and growth.best[0.4, -0.2, -0.5, 0.6] == _node().cost


def test_of_a_cell_and_its_image_one_is_tested() -> None:
    ranges = {"speed": (0.3, 0.5), "lateral_speed": (-0.3, 0.0, 0.3), "yaw_rate": (-0.6, -0.2, 0.2, 0.6)}
    domain = Domain(ranges | {"cycle_duration": (0.5, 0.7)}, np.ones((2, 3, 4, 2), dtype=bool))
    every = Growth(_solver().problem, _solver(), domain)
    mirrored = Growth(_solver().problem, _solver(), domain, images=_images())
    tested = [cell.centre for cell in fill._cells(mirrored)]
    assert len(tested) == 3 and len(fill._cells(every)) == 6
    assert {*tested, *map(_images().place, tested)} == {cell.centre for cell in fill._cells(every)}
