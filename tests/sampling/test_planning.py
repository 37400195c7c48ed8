"""A map in the making plans as the published one will, with the solves of many tasks side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from tiny_map import tiny_atlas, tiny_growth

from gaitflow.atlas.plan_solver import PlanSolver, Try
from gaitflow.runtime import GaitMap
from gaitflow.runtime.atlas import Atlas
from gaitflow.runtime.refine import FIRST_STARTS, LIMIT, RIVAL_LIMIT, RIVAL_STARTS
from gaitflow.runtime.rivals import FEW_AXES, LIKELY_FEW, UNLIKELY
from gaitflow.sampling.planning import AT_ONCE, Planned, solves, together
from tests.helpers.sheets import LAYOUT, sheet

STEPS = np.array([1.0, 1.0])
GRID = np.array([[float(x), float(y)] for x in range(4) for y in range(4)])
AMID, BEYOND = (1.5, 1.5), (3.6, 1.5)
UNSURE = [0.25] * 4  # probabilities of gaits, over few axes of none that is tried for it


def sheet_of(gait: int, cost: float, places: np.ndarray = GRID) -> object:
    made = sheet(places, np.full(len(places), cost), np.zeros_like(places))
    return made.__class__(**{**vars(made), "gait": gait})


def atlas(*sheets: object) -> Atlas:
    return Atlas(("speed", "cycle_duration"), STEPS, 1e-4, tuple(sheets))  # type: ignore[arg-type]


def nominal(place: tuple[float, ...]) -> np.ndarray:
    return np.zeros(LAYOUT.nw)


class Solver:
    """Costs of patterns by their numbers; a pattern without one has no motion."""

    def __init__(self, costs: Mapping[int, float]) -> None:
        self.costs, self.batches, self.limits = costs, list[list[int]](), list[int]()

    def __call__(self, requests: Sequence[Try], limit: int) -> list[float | None]:
        self.limits.append(limit)
        self.batches.append([pattern for pattern, _, _ in requests])
        return [self.costs.get(pattern) for pattern, _, _ in requests]


def planned(
    made: Atlas,
    place: tuple[float, ...],
    costs: Mapping[int, float],
    chances: Sequence[float] = UNSURE,
) -> tuple[Planned | None, list[int]]:
    """The plan, and the patterns that were solved in their order."""
    solver = Solver(costs)
    [plan] = together([solves(made, place, range(len(made.sheets)), nominal, chances)], solver)
    return plan, [pattern for batch in solver.batches for pattern in batch]


def test_the_cheapest_gait_is_solved_alone_where_it_costs_what_is_predicted() -> None:
    made = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2))
    assert planned(made, AMID, {0: 1.0, 1: 1.2}) == (Planned(0, 1.0), [0])


def test_what_may_cost_less_than_was_found_is_solved_too() -> None:
    made = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2), sheet_of(2, 1.6))
    assert planned(made, AMID, {0: 1.5, 1: 1.2, 2: 1.6}) == (Planned(1, 1.2), [0, 1])
    assert planned(made, AMID, {0: 1.5, 1: 1.5, 2: 1.6}) == (Planned(0, 1.5), [0, 1]), "of equal ones the first"


@pytest.mark.parametrize(
    ("chances", "costs", "plan", "solved"),
    [
        ([0.975, 0.015, 0.01, 0.0], {0: 1.0, 1: 0.9, 2: 0.8}, Planned(0, 1.0), [0]),
        ([0.535, 0.015, 0.45, 0.0], {0: 1.0, 1: 0.9, 2: 0.8}, Planned(2, 0.8), [0, 2]),
        ([0.2, 0.3, 0.5, 0.0], {0: 1.0, 1: 0.9, 2: 0.95}, Planned(1, 0.9), [2, 0, 1]),
        ([0.04, 0.95, 0.01, 0.0], {0: 1.0, 2: 0.8}, Planned(0, 1.0), [1] * FIRST_STARTS + [0]),
        ([0.29, 0.01, 0.0, 0.7], {0: 1.0, 1: 1.2}, Planned(0, 1.0), [0]),  # the likeliest is not known there
        ([0.975, 0.01, 0.015, 0.0], {0: 1.5, 1: 1.2, 2: 1.6}, Planned(1, 1.2), [0, 1]),
        ([0.985, 0.0002, 0.0148, 0.0], {0: 1.5, 1: 1.2, 2: 1.6}, Planned(0, 1.5), [0]),
    ],
)
def test_over_many_axes_likely_gaits_are_solved_first_and_in_any_case_and_unlikely_ones_are_not(
    chances: list[float], costs: dict[int, float], plan: Planned, solved: list[int]
) -> None:
    places = np.array(list(product((0.0, 1.0), repeat=4)))
    known = [(0, 1.0), (1, 1.2), (2, 1.6), (2, 1.7), (3, 0.5)]
    sheets = [sheet_of(gait, cost, places + 100.0 * (gait == 3)) for gait, cost in known]
    made = Atlas(("speed", "lateral_speed", "yaw_rate", "cycle_duration"), np.ones(4), 1e-4, tuple(sheets))  # type: ignore[arg-type]
    assert planned(made, (0.5,) * 4, costs, chances) == (plan, solved)


@pytest.mark.parametrize(
    ("chance", "costs", "plan", "solved"),
    [
        (LIKELY_FEW, {0: 1.0, 1: 0.9}, Planned(1, 0.9), [0, 1]),
        (LIKELY_FEW, {0: 1.0}, Planned(0, 1.0), [0] + [1] * FIRST_STARTS),
        (0.99 * LIKELY_FEW, {0: 1.0, 1: 0.9}, Planned(0, 1.0), [0]),
    ],
)
def test_a_gait_that_is_as_likely_the_best_as_not_is_solved_as_hard_as_the_first(
    chance: float, costs: dict[int, float], plan: Planned, solved: list[int]
) -> None:
    made = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2))
    assert planned(made, AMID, costs, [1 - chance, chance]) == (plan, solved)


@pytest.mark.parametrize(
    ("axes", "plan", "solved"), [(FEW_AXES, Planned(1, 1.2), [0, 1]), (FEW_AXES + 1, Planned(0, 1.5), [0])]
)
def test_over_more_than_a_few_axes_unlikely_rivals_are_not_solved(axes: int, plan: Planned, solved: list[int]) -> None:
    places = np.array(list(product((0.0, 1.0), repeat=axes)))
    sheets = [sheet_of(gait, cost, places) for gait, cost in ((0, 1.0), (1, 1.2))]
    made = Atlas(tuple(f"axis {n}" for n in range(axes)), np.ones(axes), 1e-4, tuple(sheets))  # type: ignore[arg-type]
    chances = [1 - UNLIKELY / 2, UNLIKELY / 2]
    assert planned(made, (0.5,) * axes, {0: 1.5, 1: 1.2}, chances) == (plan, solved)


def test_a_half_believed_rival_is_solved_too() -> None:
    near = GRID[GRID[:, 0] <= 1]
    made, place = atlas(sheet_of(0, 1.0), sheet_of(1, 0.5, near)), (1.9, 1.5)
    assert made.by_cost(np.array(place)) == [0, 1], "it comes last"
    assert planned(made, place, {0: 1.0, 1: 0.5}) == (Planned(1, 0.5), [0, 1])


def test_a_gait_without_a_motion_is_tried_from_its_nodes_and_left_for_the_next() -> None:
    made = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2))
    assert planned(made, AMID, {1: 1.2}) == (Planned(1, 1.2), [0] * FIRST_STARTS + [1])
    assert planned(made, AMID, {}) == (None, [0] * FIRST_STARTS + [1] * FIRST_STARTS)


def test_where_no_gait_is_known_nothing_is_solved() -> None:
    assert planned(atlas(sheet_of(0, 1.0)), (9.0, 9.0), {0: 1.0}) == (None, [])


def test_tasks_are_solved_side_by_side() -> None:
    made, solver = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2)), Solver({1: 1.2})
    asked = [solves(made, place, [0, 1], nominal, UNSURE) for place in (AMID, (9.0, 9.0), (0.5, 0.5))]
    told = list[int]()
    plans = together(asked, solver, told.append)
    assert told == [1] * (FIRST_STARTS + 1) + [3], "how many have ended"
    assert plans == [Planned(1, 1.2), None, Planned(1, 1.2)]
    assert solver.batches == [[0, 0]] * FIRST_STARTS + [[1, 1]]


def test_of_many_tasks_only_some_are_at_work_so_that_progress_moves() -> None:
    made, solver, told = atlas(sheet_of(0, 1.0)), Solver({0: 1.0}), list[int]()
    asked = [solves(made, AMID, [0], nominal, UNSURE) for _ in range(2 * AT_ONCE + 3)]
    assert together(asked, solver, told.append) == [Planned(0, 1.0)] * len(asked)
    assert [len(batch) for batch in solver.batches] == [AT_ONCE, AT_ONCE, 3]
    assert sorted(set(told)) == [0, AT_ONCE, 2 * AT_ONCE, len(asked)], "how many have ended"


@pytest.mark.parametrize(("cost", "limit"), [(1.5, RIVAL_LIMIT), (3.0, LIMIT)])
def test_what_may_save_a_little_gets_fewer_iterations(cost: float, limit: int) -> None:
    made, solver = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2)), Solver({0: cost, 1: 1.2})
    together([solves(made, AMID, [0, 1], nominal, UNSURE)], solver)
    assert (solver.batches, solver.limits) == ([[0], [1]], [LIMIT, limit])


def test_a_rival_has_a_second_start() -> None:
    made, solver = atlas(sheet_of(0, 1.0), sheet_of(1, 1.2)), Solver({0: 1.5})
    assert together([solves(made, AMID, [0, 1], nominal, UNSURE)], solver) == [Planned(0, 1.5)]
    assert (solver.batches, solver.limits) == ([[0], *[[1]] * RIVAL_STARTS], [LIMIT, *[RIVAL_LIMIT] * RIVAL_STARTS])


@pytest.mark.parametrize(("cost", "plan", "solved"), [(3.9, 3.9, [0]), (4.1, 4.0, [0, 1])])
def test_where_a_cost_is_far_above_what_it_might_have_been_dearer_rivals_are_solved_too(
    cost: float, plan: float, solved: list[int]
) -> None:
    made = atlas(sheet_of(0, 1.0), sheet_of(1, 4.5), sheet_of(2, 5.3))
    found, patterns = planned(made, AMID, {0: cost, 1: 4.0, 2: 1.0})
    assert found is not None and (found.cost, patterns) == (plan, solved)


@pytest.mark.parametrize("number", [0, 3])
def test_as_many_plans_as_tasks(number: int) -> None:
    made = atlas(sheet_of(0, 1.0))
    assert len(together([solves(made, AMID, [0], nominal, UNSURE) for _ in range(number)], Solver({0: 1.0}))) == number


def test_plans_are_those_of_the_published_map(pristine: Path) -> None:
    gait_map, grown = GaitMap.load(pristine), tiny_growth()
    solver = PlanSolver(grown.problem, grown.solver.patterns)
    rng = np.random.default_rng(0)
    places = [
        tuple(rng.uniform([axis[0] for axis in grown.grid], [axis[-1] for axis in grown.grid])) for _ in range(12)
    ]
    values = [dict(zip(gait_map.axes, place, strict=True)) for place in places]
    said = [dict(gait_map.select(**each, beyond=True).ranked) for each in values]
    chances = [[each[gait.name] for gait in gait_map.gaits] for each in said]
    asked = [solves(tiny_atlas(), each, [0, 1], nominal, of) for each, of in zip(places, chances, strict=True)]
    plans = together(asked, solver.costs_from)
    for each, plan in zip(values, plans, strict=True):
        published = gait_map.plan(**each, beyond=True)
        assert plan is not None and published.feasible and published.path != "fallback"
        assert gait_map.gaits[plan.gait].name == published.gait
        assert plan.cost * grown.problem.cost_scale == pytest.approx(published.cost, rel=1e-9)
