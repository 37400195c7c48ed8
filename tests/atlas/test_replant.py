"""The nodes of an earlier map are found again, spread no further, and are sown once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tiny_map import SOLVED_AT, solution_of, solved_at, task_of, tiny_atlas, tiny_domain, tiny_problem

from gaitflow.atlas.grow import Growth
from gaitflow.atlas.node import NodeSolver
from gaitflow.atlas.replant import replant
from gaitflow.core.gaits import Pattern
from gaitflow.runtime.atlas import Atlas
from gaitflow.search.solution import Solution

PATTERNS = [pattern for pattern, *_ in SOLVED_AT.values()]


def seeds() -> list[Solution]:
    return [
        solution_of(pattern, task_of(speed, cycle), solved_at(gait))
        for gait, (pattern, speed, cycle) in SOLVED_AT.items()
    ]


def empty() -> Growth:
    solver = NodeSolver(tiny_problem(), [Pattern.from_text(pattern) for pattern in PATTERNS])
    return Growth(tiny_problem(), solver, tiny_domain())


def planted(atlas: Atlas) -> Growth:
    growth = empty()
    replant(growth, atlas, PATTERNS)
    return growth


def test_every_node_is_found_again(grown: Growth) -> None:
    growth = planted(tiny_atlas())
    for sheet, nodes in enumerate(grown.nodes):
        assert set(growth.nodes[sheet]) == set(nodes)
        for place, node in nodes.items():
            again = growth.nodes[sheet][place]
            assert again.cost == pytest.approx(node.cost, rel=1e-6)
            np.testing.assert_allclose(again.slopes, node.slopes, rtol=1e-3, atol=1e-4)
    assert growth.best.keys() == grown.best.keys()


def test_what_was_planted_is_neither_sown_nor_spread(grown: Growth) -> None:
    growth = planted(tiny_atlas())
    solves = growth.solver.solves
    growth.sow(seeds())
    growth.spread()
    assert growth.solver.solves == solves < grown.solver.solves
    assert growth.start_at(0, tuple(tiny_atlas().sheets[0].tasks[0])) is None
    assert any(growth.start_at(sheet, place) for sheet, nodes in enumerate(growth.nodes) for place in nodes)


def test_a_cheaper_solution_is_sown_where_a_node_was_planted() -> None:
    growth = planted(tiny_atlas())
    solves, [first, *_] = growth.solver.solves, seeds()
    growth.sow([replace(first, cost=0.99 * first.cost)])
    assert growth.solver.solves == solves + 1


def test_what_is_not_planted_grows(grown: Growth) -> None:
    first, *others = tiny_atlas().sheets
    few = replace(first, **{name: getattr(first, name)[:2] for name in ("tasks", "costs", "slopes")})
    few = replace(few, coordinates=first.coordinates[:2], tangents=first.tangents[:2])
    growth = planted(replace(tiny_atlas(), sheets=(few, *others)))
    assert len(growth.nodes[0]) == 2
    growth.sow(seeds())
    growth.spread()
    assert set(growth.nodes[0]) == set(grown.nodes[0])


def test_places_without_a_motion_are_taken_over() -> None:
    first, *others = tiny_atlas().sheets
    beyond = np.array([[1.23, 0.45]])
    growth = planted(replace(tiny_atlas(), sheets=(replace(first, infeasible=beyond), *others)))
    assert growth.infeasible[0] == {(1.23, 0.45)} and not growth.infeasible[1]


def test_patterns_that_do_not_compete_are_left_out() -> None:
    growth = empty()
    assert replant(growth, tiny_atlas(), PATTERNS[1:]) == len(growth.nodes[1]) > 0
    assert not growth.nodes[0]
    assert replant(growth, replace(tiny_atlas(), sheets=()), PATTERNS) == 0


def test_an_atlas_of_another_problem_is_refused() -> None:
    first, *others = tiny_atlas().sheets
    fixed = replace(first.space, upper=first.space.upper.copy())
    fixed.upper[first.space.free[0]] = fixed.lower[first.space.free[0]]
    with pytest.raises(ValueError, match="leaves other variables free"):
        replant(empty(), replace(tiny_atlas(), sheets=(replace(first, space=fixed), *others)), PATTERNS)
