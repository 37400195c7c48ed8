"""Nodes are added where predictions fail, and only there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from sheets import STEPS, atlas, sheet_of
from tiny_map import GALLOP, SOLVED_AT, WALKING, solution_of, solved_at, task_of, tiny_domain, tiny_problem

from gaitflow.atlas import fill as fill_module
from gaitflow.atlas.compress import build_atlas
from gaitflow.atlas.fill import GOOD, Cell, Found, fill
from gaitflow.atlas.grow import Growth, grow
from gaitflow.atlas.node import NodeSolver, Place
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern
from gaitflow.runtime.atlas import Atlas, Prediction


@pytest.fixture
def growth() -> Growth:
    """A growth of one's own."""
    gaits = (WALKING, GALLOP)
    seeds = [solution_of(SOLVED_AT[gait][0], task_of(*SOLVED_AT[gait][1:]), solved_at(gait)) for gait in gaits]
    patterns = [Pattern.from_text(SOLVED_AT[gait][0]) for gait in gaits]
    return grow(tiny_problem(), patterns, seeds, tiny_domain())


def test_a_cell_has_parts_that_fill_it() -> None:
    parts = Cell((1.0, 2.0), (0.1, 0.2)).parts()
    assert {part.centre for part in parts} == {(0.95, 1.9), (0.95, 2.1), (1.05, 1.9), (1.05, 2.1)}
    assert all(part.half == (0.05, 0.1) for part in parts)
    assert [part.centre for part in Cell((1.0, 2.0), (0.1, 0.0)).parts()] == [(0.95, 2.0), (1.05, 2.0)]


def test_tested_are_the_cells_whose_corners_are_all_inside(growth: Growth) -> None:
    cells = fill_module._cells(growth)
    shape = tiny_domain().feasible.shape
    assert len(cells) == (shape[0] - 1) * (shape[1] - 1) - 1, "one corner of one cell is infeasible"
    assert all(growth.inside(cell.centre) for cell in cells)


def test_an_axis_of_one_value_has_no_middle() -> None:
    domain = Domain({"speed": (0.5, 0.9), "cycle_duration": (0.6,)}, np.ones((2, 1), dtype=bool))
    growth = grow(tiny_problem(), [], [], domain)
    assert fill_module._cells(growth) == [Cell((0.7, 0.6), (0.2, 0.0))]


@pytest.mark.parametrize(("iterations", "good"), [(GOOD, True), (GOOD + 1, False)])
def test_a_start_that_needs_many_iterations_is_not_good(iterations: int, good: bool) -> None:
    predicted = {0: Prediction(1.0, np.zeros(1))}
    error = fill_module._error(0, predicted, {0: Found(1.001, iterations)}, 1e-3)
    assert (error == 0) is good
    assert fill_module._error(0, predicted, {}, 1e-3) == np.inf, "a start that led nowhere"


def test_nodes_are_added_only_where_a_prediction_failed(growth: Growth, monkeypatch: pytest.MonkeyPatch) -> None:
    bad = fill_module._cells(growth)[3]
    asked: list[tuple[float, ...]] = []
    real = fill_module._errors

    def judged(
        grown: Growth, atlas: Atlas, sheets: Sequence[int], places: Sequence[Place], tolerance: float
    ) -> list[float]:
        asked.extend(places)
        if bad.centre not in places:
            return [0.0] * len(places)
        monkeypatch.setattr(fill_module, "GOOD", -1)
        (error,) = real(grown, atlas, sheets, [bad.centre], tolerance)
        monkeypatch.undo()
        monkeypatch.setattr(fill_module, "_errors", judged)
        return [error if place == bad.centre else 0.0 for place in places]

    monkeypatch.setattr(fill_module, "_errors", judged)
    before = {place for nodes in growth.nodes for place in nodes}
    fill(growth, lambda: build_atlas(growth, [0, 1]), 1e-3, rounds=2)
    assert {place for nodes in growth.nodes for place in nodes} - before == {bad.centre}
    assert asked[-4:] == [part.centre for part in bad.parts()], "its parts are tested next"


def test_what_is_added_is_predicted_well_afterwards(growth: Growth) -> None:
    atlas = build_atlas(growth, [0, 1])
    cells = fill_module._cells(growth)
    errors = fill_module._errors(growth, atlas, [0, 1], [cell.centre for cell in cells], 1e-3)
    failed = [cell for cell, error in zip(cells, errors, strict=True) if error]
    assert 0 < len(failed) < len(cells)
    again = build_atlas(growth, [0, 1])
    wrong = 0
    for cell in failed:
        asked = np.array(cell.centre)
        first = again.ranked(asked)[0]
        predicted = again.predict(first, asked)
        assert predicted is not None
        outcome = growth.solver.refined(first, cell.centre, predicted, 30)
        wrong += not outcome.converged or abs(predicted.cost / outcome.cost - 1) > 1e-3
    assert wrong <= 0.2 * len(failed)


def test_rivals_are_those_that_may_cost_least() -> None:
    ends = [(0, 0), (1, 0)]
    cheapest = sheet_of(lambda x, y: 1.0, lambda x, y: (0.0, 0.0), ends, gait=0)
    dearer = sheet_of(lambda x, y: 1.3, lambda x, y: (0.0, 0.0), ends, gait=1)
    doubtful = sheet_of(lambda x, y: 1.3, lambda x, y: (4.0, 0.0), ends, gait=2)
    asked = np.array([0.5, 0.0]) * STEPS
    assert fill_module._rivals(atlas(cheapest, dearer, doubtful), asked) == (0, [0, 2])
    assert fill_module._rivals(atlas(cheapest, dearer), asked) == (0, [0])
    assert fill_module._rivals(atlas(), asked) == (-1, [])


def test_when_tests_run_out_the_worst_cells_are_looked_into(growth: Growth, monkeypatch: pytest.MonkeyPatch) -> None:
    cells, asked = fill_module._cells(growth), list[tuple[float, ...]]()

    def judged(_: object, __: object, ___: object, places: Sequence[Place], ____: float) -> list[float]:
        asked.extend(places)
        return [float(np.inf if place == cells[5].centre else place == cells[2].centre) for place in places]

    monkeypatch.setattr(fill_module, "_errors", judged)
    monkeypatch.setattr(fill_module, "MOST_TESTS", len(cells) + 4)
    fill(growth, lambda: build_atlas(growth, [0, 1]), 1e-3, rounds=5)
    assert asked == [cell.centre for cell in cells] + [part.centre for part in cells[5].parts()]


def test_filling_twice_the_same_gives_the_same() -> None:
    def filled() -> Growth:
        gaits = (WALKING, GALLOP)
        seeds = [solution_of(SOLVED_AT[gait][0], task_of(*SOLVED_AT[gait][1:]), solved_at(gait)) for gait in gaits]
        found = grow(tiny_problem(), [Pattern.from_text(one.pattern) for one in seeds], seeds, tiny_domain())
        fill(found, lambda: build_atlas(found, [0, 1]), 1e-3, rounds=1)
        return found

    one, other = filled(), filled()
    assert [list(nodes) for nodes in one.nodes] == [list(nodes) for nodes in other.nodes]
    assert one.solver.solves == other.solver.solves


def test_over_many_axes_costs_are_tested_from_the_nominal_start(
    growth: Growth, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the nodes that this makes are kept where a cost was wrong."""
    atlas, cells = build_atlas(growth, [0, 1]), fill_module._cells(growth)
    places, before = [cell.centre for cell in cells], sum(map(len, growth.nodes))
    monkeypatch.setattr(Growth, "is_wide", True)
    monkeypatch.setattr(NodeSolver, "refinements", None)  # nobody starts from a prediction
    dearer = replace(atlas, sheets=tuple(replace(each, costs=each.costs * 1.1) for each in atlas.sheets))
    assert all(fill_module._errors(growth, dearer, [0, 1], places, 1e-3))
    added = sum(map(len, growth.nodes)) - before
    assert added >= len(places)
    errors = fill_module._errors(growth, build_atlas(growth, [0, 1]), [0, 1], places, 1e-3)
    assert not any(errors), "what was wrong is known"
    assert sum(map(len, growth.nodes)) == before + added
