from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gaitflow.config.scenario import Scenario
from gaitflow.store.attempts import MAX_ATTEMPTS, Attempts, failed_solutions
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units


def test_attempts_are_counted_on_disk_and_given_up_at_the_cap(tmp_path: Path, units: tuple[Unit, ...]) -> None:
    attempts = Attempts(tmp_path / "attempts")
    assert attempts.given_up() == set() and attempts.latest(5) == []
    numbers = [attempts.record(units[0], "crashed: SIGSEGV") for _ in range(MAX_ATTEMPTS)]
    attempts.record(units[1], "hung", detail="x" * 9999 + "the end")
    assert numbers == [1, 2, 3]
    assert Attempts(attempts.folder).count(units[0]) == 3 and attempts.given_up() == {units[0].digest}
    (latest,) = attempts.latest(1)
    assert latest.unit == units[1].digest and latest.detail.endswith("the end") and len(latest.detail) <= 4000


def test_attempts_recorded_at_once_are_all_kept(tmp_path: Path, units: tuple[Unit, ...]) -> None:
    attempts = Attempts(tmp_path)
    with ThreadPoolExecutor(6) as pool:
        numbers = sorted(pool.map(lambda _: attempts.record(units[0], "hung"), range(6)))
    assert numbers == [1, 2, 3, 4, 5, 6]


def test_a_damaged_record_still_counts(tmp_path: Path, units: tuple[Unit, ...]) -> None:
    attempts = Attempts(tmp_path)
    attempts.record(units[0], "hung")
    (tmp_path / units[0].digest / "1.json").write_bytes(b"{")
    assert [attempt.reason for attempt in attempts.of(units[0])] == ["unreadable record"]


def test_a_last_attempt_leaves_none_to_try(tmp_path: Path, units: tuple[Unit, ...]) -> None:
    attempts = Attempts(tmp_path)
    attempts.record(units[0], "crashed: SIGSEGV")
    assert attempts.record(units[0], "its worker was lost", last=True) == MAX_ATTEMPTS
    assert attempts.record(units[1], "its worker was lost", last=True) == MAX_ATTEMPTS
    assert attempts.count(units[0]) == attempts.count(units[1]) == MAX_ATTEMPTS
    assert attempts.given_up() == {units[0].digest, units[1].digest}
    assert [attempt.reason for attempt in attempts.of(units[0])] == ["crashed: SIGSEGV", "its worker was lost"]


def test_given_up_units_become_failed_rows_of_all_their_tasks(store: UnitStore, units: tuple[Unit, ...]) -> None:
    unit = units[0]
    for reason in ("crashed: SIGSEGV", "crashed: SIGSEGV", "hung"):
        store.attempts.record(unit, reason)
    rows = failed_solutions(unit, store.attempts.of(unit))
    assert [row.task for row in rows] == list(unit.tasks)
    assert {(row.status, row.solver_status) for row in rows} == {("failed", "crashed: SIGSEGV x2, hung")}
    assert store.write(unit, rows, {}) and store.validate(unit) is None


def test_a_failed_fixed_gait_keeps_its_pattern(scenario: Scenario) -> None:
    data = scenario.as_data()
    data["strategy"] |= {"name": "fixed_gait", "pattern": "0110/1100"}
    (row, *_) = failed_solutions(plan_units(Scenario.from_data(data, "test"))[0], [])
    assert row.pattern == "0110/1100" and row.gait
