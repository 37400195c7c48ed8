from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from tasks_at import at

from gaitflow.config.scenario import Strategy, Transcription, load_scenario
from gaitflow.core.trajectory import Trajectory
from gaitflow.problem import GaitProblem
from gaitflow.search import Solution, solve_tasks
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, NewSolver
from gaitflow.store import solve_record
from gaitflow.store.recorded_solver import RecordedSolver
from gaitflow.store.solve_record import Solved, SolveRecord

CHAIN = [at(0.4, 0.6), at(0.7, 0.6), at(1.0, 0.6, "held_out")]
EXACT = Transcription(phases=3, knots_per_phase=3, integrator="momentum", forces="linear", grading=1.0)


class Interrupted(Exception):
    pass


@pytest.fixture(autouse=True)
def written_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solve_record, "WRITE_EVERY_S", 0.0)


def recording(record: SolveRecord, on_solve: Callable[[Attempt, bool], None]) -> NewSolver:
    def new_solver(problem: GaitProblem, time_limit: float) -> FixedGaitSolver:
        return RecordedSolver(problem, time_limit, record, on_solve)

    return new_solver


def exactly(rows: list[Solution]) -> list[list[object]]:
    """Everything in the rows but how long they took, arrays by their bytes."""

    def plain(value: object) -> object:
        if isinstance(value, np.ndarray):
            return value.tobytes()
        if hasattr(value, "__dataclass_fields__") and not isinstance(value, type(CHAIN[0])):
            return [plain(getattr(value, field.name)) for field in fields(value)]
        return repr(value)

    skipped = ("wall_s", "cpu_s")
    return [[plain(getattr(row, f.name)) for f in fields(row) if f.name not in skipped] for row in rows]


@pytest.mark.parametrize("strategy", ["patterns", "guided", "fixed_gait"])
def test_a_search_that_goes_on_ends_as_one_that_was_not_interrupted(
    checkout: Path, tmp_path: Path, strategy: str
) -> None:
    pattern = "011/110" if strategy == "fixed_gait" else None
    own = Strategy.model_validate({"name": strategy, "pattern": pattern, "budget": 8, "restarts": 1})
    effort = load_scenario(checkout / "configs/scenarios/half-cheetah-flat-effort.yaml")
    scenario = effort.model_copy(update={"transcription": EXACT, "strategy": own})
    undisturbed = solve_tasks(scenario, CHAIN)
    solves = sum(row.solves for row in undisturbed)
    assert any(isinstance(row.trajectory, Trajectory) for row in undisturbed)
    done: list[bool] = []

    def interrupt(attempt: Attempt, known: bool, after: int) -> None:
        done.append(known)
        if len(done) == after:
            raise Interrupted

    before = 0
    for number, after in enumerate((solves // 3, 2 * solves // 3)):
        done.clear()
        record = SolveRecord(tmp_path, f"solver-{number}")
        with pytest.raises(Interrupted):
            solve_tasks(scenario, CHAIN, None, recording(record, partial(interrupt, after=after)))
        assert sum(done) == before, "what was solved is not solved again"
        before = after
    done.clear()
    record = SolveRecord(tmp_path, "solver-2")
    found = solve_tasks(scenario, CHAIN, None, recording(record, lambda attempt, known: done.append(known)))
    assert (sum(done), len(done)) == (before, solves)
    assert exactly(found) == exactly(undisturbed)


def test_what_a_kill_cut_short_or_a_disk_damaged_is_solved_again(tmp_path: Path) -> None:
    record = SolveRecord(tmp_path, "7-a")
    answers = {
        f"{i}" * 64: Solved({"cost": float("nan"), "feasible": np.bool_(True)}, (np.arange(i + 1.0),)) for i in range(4)
    }
    for name, solved in answers.items():
        record.add(name, solved)
    assert record.find("1" * 64) is None, "of its own nothing is looked up: a search asks everything once"
    (file,) = tmp_path.iterdir()
    whole = SolveRecord(tmp_path, "8-b")
    for name, solved in answers.items():
        known = whole.find(name)
        assert known is not None and known.facts["feasible"] is True and np.isnan(known.facts["cost"])
        assert known.arrays[0].tobytes() == solved.arrays[0].tobytes()
    file.write_bytes(file.read_bytes()[:-3])
    cut = SolveRecord(tmp_path, "8-b")
    assert [cut.find(name) is not None for name in answers] == [True, True, True, False]
    data = bytearray(file.read_bytes())
    data[data.index(b"\n") + 9 + 100] ^= 1
    file.write_bytes(bytes(data))
    damaged = SolveRecord(tmp_path, "8-b")
    assert [damaged.find(name) is not None for name in answers] == [True, False, False, False]
    file.write_bytes(b"\xff\n{}\n")
    assert SolveRecord(tmp_path, "8-b").find("0" * 64) is None


def test_a_disk_that_refuses_costs_nothing_but_the_record(tmp_path: Path) -> None:
    (tmp_path / "taken").touch()
    record = SolveRecord(tmp_path / "taken", "7-a")
    record.add("0" * 64, Solved({}, (np.zeros(1),)))
    assert SolveRecord(tmp_path / "taken", "8-b").find("0" * 64) is None
