from __future__ import annotations

import math

import pytest
from tasks_at import at

from gaitflow.config.scenario import Scenario, Strategy, Transcription
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.search import solve_tasks
from gaitflow.search.bonmin import NO_PATTERN, solve_restarts

TASK = at(0.5, 0.6)


@pytest.fixture(scope="module")
def tiny(effort: Scenario) -> Scenario:
    """3 phases of 2 knots: 64 patterns."""
    return effort.model_copy(
        update={
            "transcription": Transcription(phases=3, knots_per_phase=2),
            "strategy": Strategy(name="bonmin", restarts=2, seed=3, solve_time_limit=30.0),
        }
    )


def _limited(scenario: Scenario, seconds: float) -> Scenario:
    strategy = scenario.strategy.model_copy(update={"solve_time_limit": seconds})
    return scenario.model_copy(update={"strategy": strategy})


@pytest.mark.slow
def test_restarts_find_nothing_cheaper_than_the_search_over_all_patterns_and_come_close(tiny: Scenario) -> None:
    rows = solve_tasks(tiny, [TASK])
    assert [row.seed for row in rows] == [3, 4]
    searched = solve_tasks(tiny.model_copy(update={"strategy": Strategy()}), [TASK])
    best = min((row for row in searched if row.status == "solved"), key=lambda row: row.cost)
    for row in rows:
        assert row.status == "solved"
        assert row.solver_status.startswith("SUCCESS")
        pattern = Pattern.from_text(row.pattern)
        assert [pattern.touchdowns(leg) for leg in range(2)] == [1, 1]
        assert row.gait == gait_of(pattern).text
        assert best.cost * (1 - 1e-6) <= row.cost <= best.cost * 1.01
        assert row.trajectory is not None
        assert row.violation == worst(tiny.as_data(), row.trajectory, TASK, row.pattern) <= FEASIBLE
        assert (row.strategy, row.solves) == ("bonmin", 2)


@pytest.mark.slow
def test_a_restart_repeats_with_its_seed(tiny: Scenario) -> None:
    one, same = (solve_restarts(tiny, [TASK], [7])[0] for _ in range(2))
    assert (one.pattern, one.cost, one.iterations) == (same.pattern, same.cost, same.iterations)
    assert one.start == "random-7"


@pytest.mark.slow
def test_without_the_stance_setting_any_number_of_stances_is_allowed(tiny: Scenario) -> None:
    """Standing still is no gait of one stance a leg, and the best there is when nothing forbids it."""
    free = tiny.model_copy(update={"stances_per_leg": None})
    row = solve_restarts(free, [at(0.0, 0.6)], [0])[0]
    assert row.status == "solved"
    assert row.pattern == "111/111"


@pytest.mark.parametrize("seed", [0, 1])
def test_no_time_means_a_failed_row_without_a_pattern(coarse: Scenario, seed: int) -> None:
    """Stopped before any solution, Bonmin hands back a point of zeros; that is not a gait it found."""
    hurried = _limited(coarse.model_copy(update={"strategy": Strategy(name="bonmin", restarts=1)}), 1e-3)
    row = solve_restarts(hurried, [at(0.9, 0.6)], [seed])[0]
    assert (row.status, row.pattern, row.gait) == ("failed", NO_PATTERN, NO_PATTERN)
    assert row.solver_status == "LIMIT_EXCEEDED"
    assert math.isnan(row.cost)
    assert row.trajectory is None


def test_a_task_that_no_pattern_does_is_infeasible(tiny: Scenario) -> None:
    rows = solve_restarts(tiny, [at(9.0, 0.6, "held_out")], [0, 1])
    for row in rows:
        assert (row.status, row.solver_status, row.pattern) == ("infeasible", "INFEASIBLE", NO_PATTERN)
        assert (row.task.split, row.solves) == ("held_out", 1)
        assert math.isnan(row.violation)
