from __future__ import annotations

import json
from pathlib import Path

import pytest
from planted_child import PlantedChild

from benchmarks.search.scaling import random_patterns, resized, run
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, can_move
from gaitflow.core.layout import Layout


def test_random_patterns_can_move_on_one_stance_a_leg() -> None:
    drawn = random_patterns(4, 6, 200, 0)
    assert drawn == random_patterns(4, 6, 200, 0)
    assert drawn[:10] == random_patterns(4, 6, 10, 0)
    assert drawn != random_patterns(4, 6, 200, 1)
    patterns = [Pattern.from_text(text) for text in drawn]
    assert all(can_move(pattern) for pattern in patterns)
    assert {pattern.touchdowns(leg) for pattern in patterns for leg in range(4)} == {1}
    assert len({row for pattern in patterns for row in pattern.rows}) == 6 * 5, "every row there is"


def test_other_sizes_are_the_same_problem_with_room_for_their_phases(spatial: Scenario) -> None:
    eight = resized(spatial, 8, 5)
    assert eight.transcription.min_phase_fraction == pytest.approx(0.1)
    assert Layout.of(eight.as_data()).nw == 41 * 24 + 40 * 24 + 8
    assert Scenario.from_data(eight.as_data(), "test") == eight
    assert resized(spatial, 4, 3) == spatial


def test_a_table_of_two_robots(scenario: Scenario, spatial: Scenario, tmp_path: Path) -> None:
    sizes = [(4, 3), (5, 2)]
    done = run([scenario, spatial], sizes, solves=3, runs=tmp_path, map_cpu_s={spatial.name: 12.5})
    assert list(done["summary"]) == [
        f"{legs} legs, {phases} phases, {knots} knots" for legs in (2, 4) for phases, knots in sizes
    ]
    planar, larger = done["summary"]["2 legs, 4 phases, 3 knots"], done["summary"]["4 legs, 4 phases, 3 knots"]
    assert (planar["variables"], larger["variables"]) == (13 * 10 + 12 * 8 + 4 * 4 + 4, 13 * 24 + 12 * 24 + 4)
    assert (planar["patterns"], planar["patterns_any_stances"]) == (24, 43), "time may run backwards"
    assert (larger["patterns"], larger["patterns_any_stances"]) == (2628, 8296)
    for told in done["summary"].values():
        assert 0 < told["cpu_s_median"] <= told["cpu_s_p90"]
        assert 0 < told["iterations_median"] <= 300
        assert told["solves"] == 3
    rows = [row for row in done["rows"] if (row["legs"], row["phases"]) == (4, 4)]
    solved = sum(row["feasible"] for row in rows)
    assert larger["feasible"] == pytest.approx(solved / 3)
    mean = sum(row["cpu_s"] for row in rows) / 3
    assert larger["exhaustive_cpu_h"] == pytest.approx(2628 * mean / 3600)
    assert larger["cpu_s_per_labelled_task"] == 12.5
    assert done["summary"]["4 legs, 5 phases, 2 knots"]["cpu_s_per_labelled_task"] is None
    assert run([scenario, spatial], sizes, solves=3, runs=tmp_path)["rows"] == done["rows"], "nothing is solved again"
    json.dumps(done, allow_nan=False)


def test_a_lost_solve_is_a_failure_with_its_time(scenario: Scenario, tmp_path: Path, monkeypatch) -> None:
    from benchmarks import child

    class Dying(PlantedChild):
        def call(self, limit_s: float, **request: object) -> dict:
            raise child.Lost("crashed: SIGSEGV", 2.0, 2.5)

    monkeypatch.setattr(child, "Child", Dying)
    told = run([scenario], [(4, 3)], solves=2, runs=tmp_path)["summary"]["2 legs, 4 phases, 3 knots"]
    assert (told["feasible"], told["cpu_s_median"], told["cpu_s_per_solved"]) == (0.0, 2.0, None)
