from __future__ import annotations

import math

import pytest
from tasks_at import at

from benchmarks.child import Lost
from benchmarks.search.search import BONMIN_LIMIT_S, LOST, Search, bonmin, patterns, search, summarise
from gaitflow.config.scenario import Scenario
from gaitflow.search import Solution


def solution(pattern: str, gait: str, cost: float, status: str = "solved", **changes) -> Solution:
    values = {
        "task": at(1.0, 0.6), "pattern": pattern, "gait": gait, "strategy": "patterns",
        "start": "nominal", "seed": 0, "status": status, "solver_status": f"{status}!", "cost": cost,
        "violation": 1e-9, "iterations": 10, "solves": 2, "wall_s": 0.5, "cpu_s": 0.25,
    }  # fmt: skip
    return Solution(**values | changes)


GALLOP = solution("0011/0110", "0011/0110", 8.0)
WALKING = solution("0111/1101", "0111/1101", 9.0)


def test_the_cheapest_speaks_and_all_of_them_count(scenario: Scenario) -> None:
    nan = float("nan")
    found = [WALKING, solution("0001/0010", "001/010", nan, "failed"), GALLOP,
             solution("0001/0001", "01/01", nan, "screened", solves=0, cpu_s=0.0, wall_s=0.0)]  # fmt: skip
    told = summarise(scenario, found)
    assert (told["gait"], told["pattern"], told["cost"], told["status"]) == ("gallop", "0011/0110", 8.0, "solved")
    assert told["counts"] == {"failed": 1, "screened": 1, "solved": 2}
    assert told["costs"] == {"0011/0110": 8.0, "0111/1101": 9.0}
    assert (told["cpu_s"], told["wall_s"], told["solves"]) == (0.75, 1.5, 6)


def test_costs_are_kept_by_the_cyclic_representative_and_the_cheapest_of_them(scenario: Scenario) -> None:
    turned = solution("0110/1100", "0011/0110", 7.0)
    assert summarise(scenario, [GALLOP, turned])["costs"] == {"0011/0110": 7.0}
    assert summarise(scenario, [turned, GALLOP])["costs"] == {"0011/0110": 7.0}


def test_without_a_motion_there_is_no_cost(scenario: Scenario) -> None:
    nan = float("nan")
    one = summarise(scenario, [solution("none", "none", nan, "failed", solver_status="exception: thrown")])
    assert (one["status"], one["solver_status"], one["cost"], one["gait"]) == (
        "failed",
        "exception: thrown",
        None,
        None,
    )
    many = summarise(scenario, [solution("0001/0010", "001/010", nan, status) for status in ("failed", "screened")])
    assert (many["status"], many["cost"], many["costs"]) == ("infeasible", None, {})


def test_a_lost_process_is_a_row_with_its_time() -> None:
    class Dying:
        def call(self, limit_s: float, **request: object) -> None:
            raise Lost("crashed: SIGSEGV", 12.5, 13.0)

    row = search(Dying(), {"speed": 1.0, "cycle_duration": 0.6}, 3, 10.0)  # type: ignore[arg-type]
    assert (row["status"], row["cost"], row["cpu_s"], row["wall_s"]) == (LOST, None, 12.5, 13.0)
    assert row["solver_status"] == "crashed: SIGSEGV"


def test_strategies_differ_from_the_scenario_only_in_the_search(scenario: Scenario) -> None:
    theirs = Scenario.from_data(bonmin(scenario).as_data(), "test")
    assert theirs.strategy.name == "bonmin"
    assert theirs.strategy.solve_time_limit == BONMIN_LIMIT_S
    fixed = {"name": "fixed_gait", "pattern": "0110/1100"}
    given = scenario.model_copy(update={"strategy": scenario.strategy.model_copy(update=fixed)})
    ours = Scenario.from_data(patterns(given).as_data(), "test")
    assert ours == scenario
    assert theirs.problem_digest == ours.problem_digest


@pytest.mark.slow
def test_a_real_search_measures_all_of_itself(scenario: Scenario) -> None:
    told = Search(scenario.as_data())({"speed": 1.3, "cycle_duration": 0.6}, None)
    assert told["status"] == "solved"
    assert told["violation"] <= 1e-6
    assert told["cost"] == min(told["costs"].values())
    assert sum(told["counts"].values()) == 24
    assert 0 < told["cpu_s"] < told["whole_cpu_s"]
    assert math.isclose(told["cost"], 7793.71, rel_tol=0.2), "the gallop from the nominal start bounds it"
