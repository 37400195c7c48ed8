from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.scenario import Objective, Scenario, Strategy, Transcription
from gaitflow.core.layout import Layout
from gaitflow.core.task import Task
from gaitflow.search import Solution, solve_tasks
from gaitflow.search.resolve import FinerMeshes, interpolated

TASK = at(0.9, 0.6)


@pytest.fixture(scope="module")
def exact(effort: Scenario) -> Scenario:
    """J2, exact steps, 4 phases of 5 knots."""
    transcription = Transcription(knots_per_phase=5, integrator="momentum", forces="linear", grading=1.0)
    objective = Objective(tangential_velocity=1e6, normal_velocity=1e6, tilt=1e6, tilt_rate=1e6)
    return effort.model_copy(update={"transcription": transcription, "objective": objective})


@pytest.fixture(scope="module")
def rows(exact: Scenario) -> list[Solution]:
    return solve_tasks(exact, [TASK])


def _refined(rows: list[Solution]) -> list[Solution]:
    return [row for row in rows if row.refined_knots]


def _leaders(rows: list[Solution]) -> list[Solution]:
    first: dict[str, Solution] = {}
    for row in sorted((row for row in rows if row.status == "solved"), key=lambda row: row.cost):
        first.setdefault(row.gait, row)
    return list(first.values())


def test_the_cheapest_two_gaits_know_their_cost_on_a_finer_mesh(exact: Scenario, rows: list[Solution]) -> None:
    refined = _refined(rows)
    assert [row.pattern for row in _leaders(rows)[:2]] == [row.pattern for row in sorted(refined, key=lambda r: r.cost)]
    fine = exact.model_copy(
        update={"transcription": exact.transcription.model_copy(update={"knots_per_phase": refined[0].refined_knots})}
    )
    own = {row.pattern: row.cost for row in solve_tasks(fine, [TASK])}
    for row in refined:
        assert row.refined_knots == 10
        assert row.refined_cost == pytest.approx(own[row.pattern], rel=1e-5)
        assert row.cost * 0.8 < row.refined_cost < row.cost, "more knots allow more motions"
        assert row.trajectory is not None and len(row.trajectory.times) == 21, "the motion stays on its mesh"
    for row in rows:
        assert row.refined_knots in (0, 10)
        assert math.isnan(row.refined_cost) == (row.refined_knots == 0)


def test_it_is_the_same_again(exact: Scenario, rows: list[Solution]) -> None:
    again = solve_tasks(exact, [TASK])
    assert [(row.refined_cost, row.refined_knots, row.iterations) for row in _refined(again)] == [
        (row.refined_cost, row.refined_knots, row.iterations) for row in _refined(rows)
    ]


@pytest.mark.parametrize("changed", [{"integrator": "euler"}, {"integrator": "euler", "forces": "held"}])
def test_eulers_meshes_are_left_as_they_are(exact: Scenario, changed: dict[str, str]) -> None:
    transcription = exact.transcription.model_copy(update=changed)
    assert not _refined(solve_tasks(exact.model_copy(update={"transcription": transcription}), [TASK]))


def test_a_part_of_a_search_has_no_winner_to_refine(exact: Scenario) -> None:
    part = Strategy(part=(0, 2))
    assert not _refined(solve_tasks(exact.model_copy(update={"strategy": part}), [TASK]))


class Planted(FinerMeshes):
    """Costs on finer meshes by pattern and knots instead of solves, no motion without one; and what was asked."""

    def __init__(self, scenario: Scenario, costs: dict[tuple[str, int], float]) -> None:
        super().__init__(scenario)
        self.costs = costs
        self.asked: list[tuple[str, int]] = []

    def on_mesh(self, task: Task, row: Solution, knots: int) -> Solution:
        self.asked.append((row.pattern, knots))
        cost = self.costs.get((row.pattern, knots))
        return row if cost is None else replace(row, refined_cost=cost, refined_knots=knots)


@pytest.fixture
def three(rows: list[Solution]) -> list[Solution]:
    """Three gaits A, B, C at 100, 102 and 110."""
    template = next(row for row in rows if row.status == "solved")
    return [
        replace(template, pattern=name, gait=name, cost=cost, refined_cost=math.nan, refined_knots=0)
        for name, cost in (("A", 100.0), ("B", 102.0), ("C", 110.0))
    ]


def test_a_margin_beyond_the_errors_ends_it(exact: Scenario, three: list[Solution]) -> None:
    planted = Planted(exact, {("A", 10): 99.5, ("B", 10): 101.5})
    found = planted.resolved(TASK, three)
    assert planted.asked == [("A", 10), ("B", 10)]
    assert [(row.refined_cost, row.refined_knots) for row in found[:2]] == [(99.5, 10), (101.5, 10)]
    assert found[2] == three[2]


def test_rows_without_a_cost_are_not_in_the_way(exact: Scenario, three: list[Solution]) -> None:
    """They stand among the others in the order of patterns, and no number is less or more than theirs."""
    nothing = [replace(three[0], pattern=f"{n}", status="infeasible", cost=math.nan) for n in range(5)]
    mixed = [nothing[0], three[2], nothing[1], nothing[2], three[1], nothing[3], three[0], nothing[4]]
    planted = Planted(exact, {("A", 10): 99.5, ("B", 10): 101.5})
    planted.resolved(TASK, mixed)
    assert planted.asked == [("A", 10), ("B", 10)]


def test_a_tie_ends_it(exact: Scenario, three: list[Solution]) -> None:
    planted = Planted(exact, {("A", 10): 90.0, ("B", 10): 90.05})
    planted.resolved(TASK, three)
    assert len(planted.asked) == 2


def test_errors_beyond_the_margin_ask_a_finer_mesh_and_what_they_may_hide(
    exact: Scenario, three: list[Solution]
) -> None:
    """A's cost falls by 12 %: C, 10 % dearer, might be the cheapest. On 20 knots C falls most, and is 5 % cheaper."""
    costs = {("A", 10): 90.0, ("B", 10): 93.0, ("A", 20): 89.0, ("B", 20): 92.0, ("C", 20): 84.0}
    planted = Planted(exact, costs)
    found = planted.resolved(TASK, three)
    assert planted.asked[:5] == [("A", 10), ("B", 10), ("A", 20), ("B", 20), ("C", 20)]
    assert [row.refined_cost for row in found] == [89.0, 92.0, 84.0]
    # C may still be off by (110 - 84) / 84 / 3 = 10 %: the finest mesh has the last word.
    assert {knots for _, knots in planted.asked[5:]} == {40}


def test_a_gait_far_behind_is_not_asked(exact: Scenario, three: list[Solution]) -> None:
    costs = {("A", 10): 97.5, ("B", 10): 98.5, ("A", 20): 97.3, ("B", 20): 98.8}
    planted = Planted(exact, costs)
    planted.resolved(TASK, three)
    assert planted.asked == list(costs)


def test_without_a_motion_on_the_finer_mesh_it_stays_open(exact: Scenario, three: list[Solution]) -> None:
    planted = Planted(exact, {("A", 10): 99.5})
    found = planted.resolved(TASK, three)
    assert planted.asked == [("A", 10), ("B", 10)]
    assert (found[0].refined_knots, found[1].refined_knots) == (10, 0)


def test_an_only_gait_is_refined_alone(exact: Scenario, three: list[Solution]) -> None:
    planted = Planted(exact, {("A", 10): 99.5})
    assert planted.resolved(TASK, three[:1])[0].refined_cost == 99.5
    assert planted.asked == [("A", 10)]
    assert planted.resolved(TASK, []) == []


@pytest.mark.parametrize(("knots", "meshes"), [(5, (10, 20, 40)), (10, (20, 40, 50)), (20, (40, 50)), (50, ())])
def test_no_mesh_is_finer_than_allowed(exact: Scenario, knots: int, meshes: tuple[int, ...]) -> None:
    transcription = exact.transcription.model_copy(update={"knots_per_phase": knots})
    assert FinerMeshes(exact.model_copy(update={"transcription": transcription})).meshes == meshes


def test_a_motion_on_a_finer_mesh_passes_through_its_knots(exact: Scenario, rows: list[Solution]) -> None:
    motion = next(row.trajectory for row in rows if row.trajectory is not None)
    coarse = Layout.of(exact.as_data())
    fine = replace(coarse, knots_per_phase=10)
    finer = interpolated(motion, coarse, fine)
    for name in ("times", "base", "feet"):
        np.testing.assert_allclose(getattr(finer, name)[::2], getattr(motion, name), atol=1e-9)
    np.testing.assert_allclose(finer.forces[::2], motion.forces, atol=1e-9)
    np.testing.assert_allclose(finer.end_forces[1::2], motion.end_forces, atol=1e-9)
    np.testing.assert_allclose(finer.end_forces[::2], finer.forces[1::2], atol=1e-9)
    again = fine.unpack(fine.pack(finer, TASK.cycle_duration), TASK.cycle_duration)
    np.testing.assert_allclose(again.end_forces, finer.end_forces, atol=1e-9)
    # A ballistic flight is a parabola, which the cubic has exactly.
    flight = replace(motion, base=motion.base.copy())
    flight.base[:, 1] = 1.0 - 4.905 * flight.times**2
    flight.base[:, 4] = -9.81 * flight.times
    rough = interpolated(flight, coarse, replace(coarse, knots_per_phase=7))
    np.testing.assert_allclose(rough.base[:, 1], 1.0 - 4.905 * rough.times**2, atol=1e-12)
