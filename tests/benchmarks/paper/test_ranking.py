from __future__ import annotations

import pytest
from tasks_at import at

from benchmarks.paper import ranking
from gaitflow.config.scenario import Scenario, Strategy
from gaitflow.dataset.read import Solutions
from gaitflow.search import Solution, solve_tasks
from gaitflow.tables.solutions import solutions_to_table

TASK = at(0.4, 0.6)
TROT, CRAWL = "0111/1101/1101/0111", "0111/1101/1110/1011"


@pytest.fixture(scope="module")
def found(spatial: Scenario) -> list[Solution]:
    """A walking trot and a crawl, on a coarse mesh."""
    gaits = [Strategy(name="fixed_gait", pattern=pattern) for pattern in (CRAWL, TROT)]
    return [row for own in gaits for row in solve_tasks(spatial.model_copy(update={"strategy": own}), [TASK])]


def ranked(scenario: Scenario, rows: list[Solution]) -> dict:
    return ranking.run(
        scenario, Solutions(solutions_to_table(rows, scenario.as_data()), {"scenario": scenario.as_data()})
    )


def test_gaits_come_by_cost_with_what_they_ask(spatial: Scenario, found: list[Solution]) -> None:
    done = ranked(spatial, found)
    best, other = done["rows"]
    assert (best["rank"], best["gait"], best["pattern"], best["margin_rel"]) == (1, "walking trot", TROT, 0.0)
    assert (other["rank"], other["gait"]) == (2, "four-beat walk")
    assert other["margin_rel"] == pytest.approx(found[0].cost / found[1].cost - 1)
    assert other["margin_rel"] > 0.05
    trajectory = found[1].trajectory
    assert trajectory is not None
    assert best["peak_force_share"] == pytest.approx(trajectory.forces[..., 2].max() / 500.0)
    swing = trajectory.durations[0] / TASK.cycle_duration
    assert best["duty"][0] == pytest.approx(1 - swing)
    assert max(row["violation"] for row in done["rows"]) <= 1e-6
    summary = done["summary"]
    assert summary["kinds"] == {"walking trot": 1}
    assert summary["margin_to_other_kind_min_rel"] == summary["margin_to_runner_up_min_rel"] == other["margin_rel"]


def test_a_limit_that_is_active_has_the_share_one(spatial: Scenario, found: list[Solution]) -> None:
    trajectory = found[1].trajectory
    assert trajectory is not None
    most = float(abs(trajectory.foot_velocities).max())
    robot = spatial.robot.model_copy(update={"max_foot_speed": most})
    row = ranked(spatial.model_copy(update={"robot": robot}), found[1:])["rows"][0]
    assert row["peak_speed_share"] == pytest.approx(1.0)


def test_without_another_kind_there_is_no_margin_to_one(spatial: Scenario, found: list[Solution]) -> None:
    summary = ranked(spatial, found[1:])["summary"]
    assert summary["tasks"] == 1
    assert summary["margin_to_other_kind_min_rel"] is summary["margin_to_runner_up_min_rel"] is None
