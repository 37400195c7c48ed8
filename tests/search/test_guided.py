from __future__ import annotations

import math
from collections import Counter
from typing import Any

import pytest
from tasks_at import at

from gaitflow.config.scenario import Objective, Scenario, Strategy, Transcription
from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern, Symmetry, gait_of
from gaitflow.core.task import Task
from gaitflow.search import Solution, solve_tasks
from gaitflow.search.probes import coarse, halved
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver

CHAIN = [at(0.4, 0.6), at(0.9, 0.6)]
GUIDED = Strategy(name="guided", restarts=1)


def _best(rows: list[Solution], task: Task) -> Solution:
    return min((row for row in rows if row.task == task and row.status == "solved"), key=lambda row: row.cost)


@pytest.fixture(scope="module")
def vibration(effort: Scenario) -> Scenario:
    """J2 with 5 knots a phase, whose costs differ by far more than those of J1."""
    objective = Objective(tangential_velocity=1e6, normal_velocity=1e6, tilt=1e6, tilt_rate=1e6)
    settings = Transcription(knots_per_phase=5)
    return effort.model_copy(update={"objective": objective, "strategy": GUIDED, "transcription": settings})


@pytest.fixture(scope="module")
def rows(vibration: Scenario) -> list[Solution]:
    return solve_tasks(vibration, CHAIN)


def test_in_the_plane_it_finds_what_the_exhaustive_search_finds(vibration: Scenario, rows: list[Solution]) -> None:
    every = solve_tasks(vibration.model_copy(update={"strategy": Strategy(restarts=1)}), CHAIN)
    for task in CHAIN:
        ours, best = _best(rows, task), _best(every, task)
        assert ours.cost <= best.cost * (1 + 1e-6)


def test_rows_tell_what_was_done_with_each_pattern(vibration: Scenario, rows: list[Solution]) -> None:
    assert [(row.task, row.pattern) for row in rows] == sorted({(row.task, row.pattern) for row in rows})
    assert all(row.strategy == "guided" for row in rows)
    counts = Counter(row.status for row in rows)
    assert min(counts["solved"], counts["probed"], counts["screened"]) >= 2
    for row in rows:
        if row.status == "solved":
            assert row.trajectory is not None
            own = worst(vibration.as_data(), row.trajectory, row.task, row.pattern)
            assert row.violation == own <= FEASIBLE
            assert row.gait == gait_of(Pattern.from_text(row.pattern)).text
        else:
            assert math.isnan(row.cost) and row.trajectory is None
            assert row.solver_status
        assert (row.solves == 0) == (row.status == "screened")
        assert (row.cpu_s > 0) == (row.solves > 0)


def test_the_second_task_starts_from_the_first(rows: list[Solution]) -> None:
    second = [row for row in rows if row.task == CHAIN[1]]
    assert any(row.start == "neighbour" for row in second)
    assert not any(row.start == "neighbour" for row in rows if row.task == CHAIN[0])


def test_it_gives_the_same_again(vibration: Scenario, rows: list[Solution]) -> None:
    again = solve_tasks(vibration, CHAIN)
    assert [(row.pattern, row.status, row.iterations, repr(row.cost)) for row in again] == [
        (row.pattern, row.status, row.iterations, repr(row.cost)) for row in rows
    ]


def test_the_budget_bounds_the_probes(effort: Scenario) -> None:
    strategy = Strategy(name="guided", restarts=1, budget=3)
    found = solve_tasks(effort.model_copy(update={"strategy": strategy}), CHAIN[:1])
    assert 1 <= sum(row.status in ("probed", "solved") for row in found) <= 3


def test_where_nothing_can_be_walked_it_says_so(effort: Scenario) -> None:
    """Feet at 8 m/s could follow, but the stances of a long cycle leave the boxes."""
    scenario = effort.model_copy(update={"strategy": GUIDED, "transcription": Transcription(knots_per_phase=3)})
    found = solve_tasks(scenario, [at(6.0, 1.6)])
    assert found
    assert {row.status for row in found} <= {"infeasible", "failed", "screened", "probed"}
    assert any(row.status == "infeasible" for row in found)
    assert all(math.isnan(row.cost) for row in found)


def test_in_space_costs_fall_from_the_library_to_the_winner(anymal: Scenario) -> None:
    """ANYmal walks at 0.4 m/s in a trot with double support; no leg is ever all in the air."""
    found = solve_tasks(anymal.model_copy(update={"strategy": GUIDED}), [at(0.4, 0.6)])
    best = _best(found, at(0.4, 0.6))
    assert best.gait == gait_of(Pattern.from_text("0111/1101/1101/0111"), Symmetry(mirror=(1, 0, 3, 2))).text
    assert len(found) < 300
    screened = [row for row in found if row.status == "screened"]
    assert any(row.solver_status.startswith("costs at least") for row in screened)


def test_half_the_phases_have_the_same_mesh(anymal: Scenario) -> None:
    settings = {"phases": 8, "knots_per_phase": 5, "min_phase_fraction": 0.1}
    eight = anymal.model_copy(update={"transcription": anymal.transcription.model_copy(update=settings)})
    four = halved(eight).transcription
    assert (four.phases, four.knots_per_phase, four.min_phase_fraction) == (4, 10, 0.2)
    assert coarse(eight).transcription.knots_per_phase == 3
    assert coarse(four := halved(eight)).transcription.knots_per_phase == 4, four


def test_eight_phases_begin_with_what_four_can_do(effort: Scenario) -> None:
    """In the plane, where a gait of four phases is one of eight, too: it must not come out dearer."""
    task = at(0.9, 0.6)
    four = effort.model_copy(
        update={"strategy": GUIDED, "transcription": Transcription(phases=4, knots_per_phase=6, min_phase_fraction=0.2)}
    )
    eight = effort.model_copy(
        update={"strategy": GUIDED, "transcription": Transcription(phases=8, knots_per_phase=3, min_phase_fraction=0.1)}
    )
    best_of_four, best_of_eight = (_best(solve_tasks(one, [task]), task).cost for one in (four, eight))
    assert best_of_eight <= best_of_four * (1 + 1e-6)


def test_every_solver_call_is_in_some_row(effort: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that failed at the neighbour's start and those with half as many phases, too."""
    calls = []
    honest = FixedGaitSolver.solve

    def solve(self: FixedGaitSolver, *arguments: Any, **options: Any) -> Attempt:
        calls.append(honest(self, *arguments, **options))
        return calls[-1]

    monkeypatch.setattr(FixedGaitSolver, "solve", solve)
    settings = Transcription(phases=6, knots_per_phase=3, min_phase_fraction=0.1)
    scenario = effort.model_copy(update={"strategy": GUIDED, "transcription": settings})
    found = solve_tasks(scenario, CHAIN)
    assert sum(row.solves for row in found) == len(calls)
    assert sum(row.iterations for row in found) == sum(call.iterations for call in calls)
    assert math.isclose(sum(row.cpu_s for row in found), sum(call.cpu_s for call in calls))
