from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.scenario import Scenario, Strategy, Transcription
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern, Symmetry, all_patterns, gait_of
from gaitflow.core.task import Task
from gaitflow.search import Solution, solve_tasks
from gaitflow.search.attempts import best_of
from gaitflow.search.exhaustive import candidate_patterns, solve_chain
from gaitflow.search.rows import solution
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, Start

Solve = Callable[..., Attempt]
CHAIN = [at(0.4, 0.6), at(0.7, 0.6), at(1.0, 0.6, "held_out")]


@pytest.fixture(scope="module")
def small(effort: Scenario) -> Scenario:
    """3 phases of 3 knots, any number of stances: 24 patterns, standing and flying among them."""
    return effort.model_copy(
        update={"transcription": Transcription(phases=3, knots_per_phase=3), "stances_per_leg": None}
    )


@pytest.fixture(scope="module")
def rows(small: Scenario) -> list[Solution]:
    return solve_chain(small, CHAIN)


def test_a_row_per_task_and_pattern_in_that_order(small: Scenario, rows: list[Solution]) -> None:
    patterns = candidate_patterns(small, CHAIN[0])
    assert patterns == all_patterns(2, 3)
    assert [(row.task, row.pattern) for row in rows] == [(task, one.text) for task in CHAIN for one in patterns]


def test_screened_rows_say_why_and_were_not_solved(rows: list[Solution]) -> None:
    screened = [row for row in rows if row.status == "screened"]
    assert Counter(row.solver_status for row in screened) == {
        "no leg ever stands": 3,
        "a leg never leaves the ground": 3 * 7,
    }
    for row in screened:
        assert (row.solves, row.iterations, row.cpu_s) == (0, 0, 0.0)
        assert math.isnan(row.cost) and math.isnan(row.violation)
        assert row.trajectory is None and row.multipliers is None


def test_solved_rows_hold_what_the_check_confirms(small: Scenario, rows: list[Solution]) -> None:
    solved = [row for row in rows if row.status == "solved"]
    assert len(solved) >= 30
    for row in solved:
        assert row.trajectory is not None and row.multipliers is not None
        own = worst(small.as_data(), row.trajectory, row.task, row.pattern)
        assert row.violation == own <= FEASIBLE
        h = np.diff(row.trajectory.times)
        assert row.cost == pytest.approx(h @ (row.trajectory.forces**2).sum(axis=(1, 2)))
        assert row.gait == gait_of(Pattern.from_text(row.pattern)).text
        assert row.solves >= 1 and row.iterations > 0


def test_each_task_starts_from_its_neighbour(rows: list[Solution]) -> None:
    """A pattern solved at one task starts there at the next, primal and dual, and needs fewer iterations for it."""
    first, second = rows[: len(rows) // 3], rows[len(rows) // 3 : 2 * len(rows) // 3]
    assert not any(row.start == "neighbour" for row in first)
    pairs = [(a, b) for a, b in zip(first, second, strict=True) if a.solves == b.solves == 1]
    assert len(pairs) >= 5
    for cold, warm in pairs:
        assert (cold.start, warm.start) == ("nominal", "neighbour")
    assert sum(b.iterations for _, b in pairs) < 0.7 * sum(a.iterations for a, _ in pairs)


def test_the_cheapest_gaits_were_solved_from_another_start_too(rows: list[Solution]) -> None:
    for number in range(len(CHAIN)):
        of_task = rows[number * len(rows) // 3 : (number + 1) * len(rows) // 3]
        solved = [row for row in of_task if row.status == "solved"]
        leaders = {}
        for row in sorted(solved, key=lambda row: row.cost):
            leaders.setdefault(row.gait, row)
        for row in list(leaders.values())[:2]:
            assert row.solves >= 2, row


def test_a_chain_gives_the_same_bytes_again(small: Scenario, rows: list[Solution]) -> None:
    again = solve_chain(small, CHAIN)
    assert np.array([row.cost for row in again]).tobytes() == np.array([row.cost for row in rows]).tobytes()
    assert [(row.iterations, row.start, row.status) for row in again] == [
        (row.iterations, row.start, row.status) for row in rows
    ]
    for one, other in zip(rows, again, strict=True):
        if one.trajectory is not None:
            assert other.trajectory is not None
            assert one.trajectory.forces.tobytes() == other.trajectory.forces.tobytes()


@pytest.fixture(scope="module")
def one_gait(small: Scenario) -> Scenario:
    """A single pattern to try, with two restarts."""
    return small.model_copy(update={"strategy": Strategy(name="fixed_gait", pattern="011/110", restarts=2)})


def test_local_infeasibility_ends_the_search_for_a_pattern(one_gait: Scenario) -> None:
    """At 3 m/s the feet cannot keep up, which the screen does not know: one start, one verdict."""
    (row,) = solve_chain(one_gait, [at(3.0, 0.6)])
    assert (row.status, row.solves) == ("infeasible", 1)
    assert row.violation > 1e-3
    assert math.isnan(row.cost) and row.trajectory is None


def test_restarts_follow_where_the_solver_gave_up(one_gait: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the nominal start at the first task; at a task whose neighbour failed too, one start must do."""
    starts = []

    def solve(self: FixedGaitSolver, pattern: Pattern, task: Task, start: Start, fallback: bool = True) -> Attempt:
        starts.append((task.speed, start.name))
        return replace(honest(self, pattern, task, start, fallback), feasible=False, gave_up=True)

    honest = FixedGaitSolver.solve
    monkeypatch.setattr(FixedGaitSolver, "solve", solve)
    rows = solve_chain(one_gait, CHAIN[:2])
    assert starts == [(0.4, "nominal"), (0.4, "random-0"), (0.4, "random-1"), (0.7, "nominal")]
    assert [(row.status, row.solves) for row in rows] == [("failed", 3), ("failed", 1)]


def test_fixed_gait_gives_one_row_a_task(small: Scenario) -> None:
    strategy = Strategy(name="fixed_gait", pattern="110/011", restarts=1)
    rows = solve_tasks(small.model_copy(update={"strategy": strategy}), CHAIN)
    assert [row.task for row in rows] == CHAIN
    for row in rows:
        assert (row.status, row.strategy, row.pattern, row.gait) == ("solved", "fixed_gait", "110/011", "011/101")


def test_one_stance_leaves_the_patterns_with_one_touchdown(effort: Scenario, anymal: Scenario) -> None:
    planar = candidate_patterns(effort, CHAIN[0])
    assert len(planar) == 36
    assert all(pattern.touchdowns(leg) == 1 for pattern in planar for leg in range(2))
    spatial = candidate_patterns(anymal, CHAIN[0])
    assert spatial == all_patterns(4, 4, 1, Symmetry(mirror=(1, 0, 3, 2)))
    assert len(spatial) == 2628  # of 12^4 rows, up to rotation and with left and right as one


def test_the_best_is_the_cheapest_feasible_and_the_earliest_of_equals(effort: Scenario, solve: Solve) -> None:
    true = solve(effort, "0110/1100", 0.9, 0.6)

    def attempt(name: str, cost: float, feasible: bool = True) -> Attempt:
        return replace(true, start=name, cost=cost, feasible=feasible)

    assert best_of([]) is None
    assert best_of([attempt("a", 1.0, False)]) is None
    found = best_of([attempt("a", 2.0), attempt("b", 1.0, False), attempt("c", 1.5), attempt("d", 1.7)])
    assert found is not None and found.start == "c"
    found = best_of([attempt("a", 1.0), attempt("b", 1.0 - 1e-8)])  # rounding, not another basin
    assert found is not None and found.start == "a"
    found = best_of([attempt("a", 1.0), attempt("b", 1.0 - 1e-5)])
    assert found is not None and found.start == "b"


def test_a_row_fails_only_when_every_attempt_gave_up(effort: Scenario, solve: Solve) -> None:
    true = solve(effort, "0110/1100", 0.9, 0.6)
    task, pattern = at(0.9, 0.6), Pattern.from_text("0110/1100")
    stopped = replace(true, start="a", feasible=False, gave_up=True, violation=0.3)
    refuted = replace(true, start="b", feasible=False, gave_up=False, violation=0.1)
    assert solution(effort, task, pattern, [stopped, stopped]).status == "failed"
    row = solution(effort, task, pattern, [stopped, refuted])
    assert (row.status, row.start, row.violation) == ("infeasible", "b", 0.1)
    assert (row.solves, row.iterations) == (2, 2 * true.iterations)
    assert math.isnan(row.cost) and row.trajectory is None
    row = solution(effort, task, pattern, [stopped, refuted, true])
    assert (row.status, row.start, row.cost, row.solves) == ("solved", "nominal", true.cost, 3)


def test_one_broken_solve_costs_one_row(small: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """A solver that never succeeds for one pattern leaves every other row as it was."""
    honest = FixedGaitSolver.solve

    def solve(self: FixedGaitSolver, pattern: Pattern, task: Task, start: Start, fallback: bool = True) -> Attempt:
        attempt = honest(self, pattern, task, start)
        if pattern.text == "001/010":
            return replace(attempt, feasible=False, gave_up=True, solver_status="exception: planted")
        return attempt

    untouched = solve_chain(small, CHAIN[:1])
    monkeypatch.setattr(FixedGaitSolver, "solve", solve)
    rows = solve_chain(small, CHAIN[:1])
    broken = [row for row in rows if row.pattern == "001/010"]
    assert [(row.status, row.solver_status) for row in broken] == [("failed", "exception: planted")]
    others = [(row.pattern, row.status) for row in rows if row.pattern != "001/010"]
    assert others == [(row.pattern, row.status) for row in untouched if row.pattern != "001/010"]
