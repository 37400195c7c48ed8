"""The atlas keeps what its nodes know, in the size that it may have."""

from __future__ import annotations

import numpy as np
import pytest

from gaitflow.atlas.compress import _modes, _tear, _without_strays, build_atlas
from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import BARRIER
from gaitflow.core.domain import Domain
from gaitflow.runtime.atlas_file import atlas_bytes
from gaitflow.runtime.atlas_reader import parse_atlas
from gaitflow.runtime.condensed import Condenser

EVERYTHING = 10**9


def test_with_all_modes_a_sheet_gives_its_nodes_back(grown: Growth) -> None:
    atlas = build_atlas(grown, [0, 1], EVERYTHING)
    assert [sheet.gait for sheet in atlas.sheets] == [0, 1]
    for sheet, nodes in zip(atlas.sheets, grown.nodes, strict=True):
        condenser = Condenser(sheet.space, BARRIER)
        assert [tuple(place) for place in sheet.tasks.tolist()] == sorted(nodes)
        for row, place in enumerate(sorted(nodes)):
            node, kept = nodes[place], condenser.expanded(sheet.mean + sheet.coordinates[row] @ sheet.modes)
            free = len(sheet.space.free)
            np.testing.assert_allclose(kept[:free], node.point[:free], atol=1e-3)
            np.testing.assert_allclose(kept[-sheet.space.bounds :], node.point[-sheet.space.bounds :], atol=0.05)
            along = sheet.tangents[row] @ sheet.modes
            np.testing.assert_allclose(along[:, :free], node.tangents[:, :free], atol=1e-2)
            assert sheet.costs[row] == node.cost
            np.testing.assert_array_equal(sheet.slopes[row], node.slopes)


def test_prediction_at_a_node_is_the_node(grown: Growth) -> None:
    atlas = build_atlas(grown, [0, 1], EVERYTHING)
    for number, nodes in enumerate(grown.nodes):
        place, node = sorted(nodes.items())[len(nodes) // 2]
        predicted = atlas.predict(number, np.array(place))
        assert predicted is not None
        assert predicted.cost == pytest.approx(node.cost, rel=1e-6)


@pytest.mark.parametrize("largest", [75_000, 140_000])
def test_an_atlas_has_the_size_that_it_may_have(grown: Growth, largest: int) -> None:
    assert 0.8 * largest < len(atlas_bytes(build_atlas(grown, [0, 1], largest))) <= largest


def test_too_little_room_leaves_one_mode_a_pattern(grown: Growth) -> None:
    assert [len(sheet.modes) for sheet in build_atlas(grown, [0, 1], 1).sheets] == [1, 1]


def test_equal_nodes_give_equal_bytes_that_can_be_read(grown: Growth) -> None:
    content = atlas_bytes(build_atlas(grown, [0, 1]))
    assert content == atlas_bytes(build_atlas(grown, [0, 1]))
    problem = grown.problem
    read = parse_atlas(content, tuple(grown.domain.axes), 2, problem.layout, problem.ng, "atlas")
    np.testing.assert_array_equal(read.steps, grown.steps)
    for one, other in zip(read.sheets, build_atlas(grown, [0, 1]).sheets, strict=True):
        for name in ("mean", "modes", "coordinates", "tangents"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_pattern_without_a_node_has_no_sheet(grown: Growth) -> None:
    empty = Growth(grown.problem, grown.solver, grown.domain)
    empty.nodes[1] = grown.nodes[1]
    assert [sheet.gait for sheet in build_atlas(empty, [0, 1]).sheets] == [1]
    assert build_atlas(Growth(grown.problem, grown.solver, grown.domain), [0, 1]).sheets == ()


def test_nodes_outside_the_domain_are_left_out(grown: Growth) -> None:
    feasible = grown.domain.feasible.copy()
    feasible[-1] = False  # of its largest speed
    inside = Growth(grown.problem, grown.solver, Domain(grown.domain.axes, feasible))
    inside.nodes, inside.infeasible = grown.nodes, grown.infeasible
    atlas = build_atlas(inside, [0, 1])
    kept = {tuple(place) for sheet in atlas.sheets for place in sheet.tasks.tolist()}
    assert kept == {place for nodes in grown.nodes for place in nodes if inside.inside(place)}
    assert any(not inside.inside(place) for nodes in grown.nodes for place in nodes)
    feasible = np.ones_like(feasible)
    feasible[0] = False  # of its least speed
    fast = Growth(grown.problem, grown.solver, Domain(grown.domain.axes, feasible))
    fast.nodes = [{at: node for at, node in grown.nodes[0].items() if not fast.inside(at)}, grown.nodes[1]]
    assert fast.nodes[0] and fast.numbers_of(build_atlas(fast, [0, 1])) == [1], "its first sheet is not pattern 0"
    nowhere = Growth(grown.problem, grown.solver, Domain(grown.domain.axes, np.zeros_like(feasible)))
    nowhere.nodes = grown.nodes
    assert build_atlas(nowhere, [0, 1]).sheets == ()


def test_modes_are_the_directions_of_largest_change() -> None:
    points = np.zeros((3, 5))
    points[:, 1] = [-2.0, 0.0, 2.0]
    tangents = np.zeros((3, 1, 5))
    tangents[:, 0, 4] = 1.0
    modes, sizes = _modes(points, tangents)
    np.testing.assert_allclose(np.abs(modes), [[0, 1, 0, 0, 0], [0, 0, 0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(sizes, [8.0, 0.75])


def test_one_node_that_nothing_changes_has_a_mode_all_the_same() -> None:
    modes, sizes = _modes(np.zeros((1, 4)), np.zeros((1, 2, 4)))
    assert modes.shape == (1, 4) and sizes.tolist() == [0.0]


def test_a_node_without_anything_in_common_with_its_neighbours_is_replaced() -> None:
    points = np.arange(6.0)[:, None] * np.ones(3)
    points[2] = 1e6
    tangents = np.ones((6, 1, 3))
    tangents[2] = 1e9
    pairs = np.array([[i, i + 1] for i in range(5)])
    kept, along = _without_strays(pairs, points, tangents)
    np.testing.assert_allclose(kept[2], 2.0)
    np.testing.assert_allclose(along, 1.0)
    np.testing.assert_array_equal(np.delete(kept, 2, axis=0), np.delete(points, 2, axis=0))


def test_tear_is_measured_half_way_between_neighbours() -> None:
    places = np.array([[0.0], [1.0], [2.0]])
    pairs = np.array([[0, 1], [1, 2]])
    bent = places**2
    assert _tear(pairs, places, bent, 2 * places[:, None]) == pytest.approx(0.0, abs=1e-12), (
        "a parabola's tangents meet"
    )
    assert _tear(pairs, places, bent, np.zeros((3, 1, 1))) == pytest.approx(4 * 2.0)
