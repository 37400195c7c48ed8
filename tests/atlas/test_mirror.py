"""The image of a node is the node that a solve of the image's task would find."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gaitflow.atlas import fill
from gaitflow.atlas.compress import build_atlas, cost_atlas
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.mirror import NodeImages
from gaitflow.atlas.node import Node, NodeSolver
from gaitflow.atlas.replant import replant
from gaitflow.config.scenario import load_scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.dataset.mirror import MirrorImage
from gaitflow.problem import transcribe
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.runtime.atlas_reader import parse_atlas
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


def _pair() -> Growth:
    """A pattern with two nodes, and its image's."""
    ranges = {"speed": (0.3, 0.5), "lateral_speed": (-0.3, 0.3), "yaw_rate": (-0.6, 0.6), "cycle_duration": (0.5, 0.7)}
    growth = Growth(_solver().problem, _solver(), Domain(ranges, np.ones((2, 2, 2, 2), dtype=bool)), images=_images())
    beside = (0.45, 0.2, 0.5, 0.6)
    for node in (_node(), _solver().node(0, beside, _node().moved(beside))):
        assert growth.keep(0, node)
    growth.give_up(0, (0.5, 0.3, 0.6, 0.5))
    return growth


def test_the_sheet_of_an_image_has_the_image_s_nodes() -> None:
    growth = _pair()
    atlas = build_atlas(growth, [0, 1])
    one, other = atlas.sheets
    assert one.image is None and other.image is not None and other.image.of == WALK.text
    assert (other.pattern, other.gait) == (IMAGE.text, 1)
    assert other.infeasible.tolist() == [[0.5, -0.3, -0.6, 0.5]] and one.infeasible.tolist() == [[0.5, 0.3, 0.6, 0.5]]
    for place, node in growth.nodes[1].items():
        predicted = atlas.predict(1, np.array(place))
        assert predicted is not None and predicted.cost == pytest.approx(node.cost, rel=1e-6)
        np.testing.assert_allclose(predicted.point, node.point, atol=0.05)
        free = len(other.space.free)
        np.testing.assert_allclose(predicted.point[:free], node.point[:free], atol=1e-3)
        near = np.array(place) + np.array([0.01, -0.02, -0.03, 0.01])
        whole = cost_atlas(growth, [0, 1]).costs(near)
        np.testing.assert_allclose(atlas.costs(near), whole, rtol=1e-9)


def test_a_file_has_the_numbers_of_an_image_once() -> None:
    atlas, problem = build_atlas(_pair(), [0, 1]), _solver().problem
    content = atlas_bytes(atlas)
    alone = atlas_bytes(replace(atlas, sheets=(replace(atlas.sheets[1], image=None),)))
    assert len(content) < 1.5 * len(alone)
    read = parse_atlas(content, AXES, 2, problem.layout, problem.ng, "atlas")
    assert atlas_bytes(read) == content
    for name in ("tasks", "slopes", "mean", "modes", "coordinates", "tangents", "infeasible"):
        np.testing.assert_array_equal(getattr(read.sheets[1], name), getattr(atlas.sheets[1], name))
    of_image = atlas_bytes(read.of([1]))
    [whole] = parse_atlas(of_image, AXES, 1, problem.layout, problem.ng, "atlas").sheets
    assert whole.image is None, "without the other sheet its numbers are written out"
    np.testing.assert_array_equal(whole.modes, atlas.sheets[1].modes)


def test_of_a_cell_and_its_image_one_is_tested() -> None:
    ranges = {"speed": (0.3, 0.5), "lateral_speed": (-0.3, 0.0, 0.3), "yaw_rate": (-0.6, -0.2, 0.2, 0.6)}
    domain = Domain(ranges | {"cycle_duration": (0.5, 0.7)}, np.ones((2, 3, 4, 2), dtype=bool))
    every = Growth(_solver().problem, _solver(), domain)
    mirrored = Growth(_solver().problem, _solver(), domain, images=_images())
    tested = [cell.centre for cell in fill._cells(mirrored)]
    assert len(tested) == 3 and len(fill._cells(every)) == 6
    assert {*tested, *map(_images().place, tested)} == {cell.centre for cell in fill._cells(every)}


def test_a_planted_node_brings_its_image() -> None:
    before, atlas = _pair(), build_atlas(_pair(), [0, 1])
    growth = Growth(_solver().problem, _solver(), before.domain, images=_images())
    solves = _solver().solves
    assert replant(growth, atlas, [WALK.text, IMAGE.text]) == 2 == _solver().solves - solves
    for sheet in (0, 1):
        assert set(growth.nodes[sheet]) == set(before.nodes[sheet])
        assert growth.infeasible[sheet] == before.infeasible[sheet]
