from __future__ import annotations

import json
import subprocess
import sys
import time

import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.execute.drivers import the_local_driver
from gaitflow.execute.status import JobCounts, run_status
from gaitflow.store.journal import Journal, read_journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit


def pretend_solved(store: UnitStore, unit: Unit) -> None:
    part = store.path(unit.digest)
    part.parent.mkdir(parents=True, exist_ok=True)
    part.touch()


def test_before_during_and_after_a_run(store: UnitStore, scenario: Scenario, units: tuple[Unit, ...]) -> None:
    before = run_status(scenario, store)
    assert (before.units, before.left, before.cpu_hours_spent, before.cpu_hours_left) == (6, 6, 0.0, None)
    assert not store.folder.exists(), "asking writes nothing"
    journal = Journal(store.folder / "journal", "7-a")
    for unit in units[:2]:
        journal.started(unit.digest)
        journal.stored(unit.digest, cpu_s=1800.0, wall_s=2000.0, kept=True)
        journal.stored(unit.digest, cpu_s=9999.0, wall_s=9999.0, kept=False)
        pretend_solved(store, unit)
    for _ in range(3):
        store.attempts.record(units[2], "crashed: SIGSEGV")
    pretend_solved(store, units[2])
    during = run_status(scenario, store)
    assert (during.solved, during.failed, during.left) == (2, 1, 3)
    assert during.cpu_hours_spent == pytest.approx(1.0) and during.cpu_hours_left == pytest.approx(1.5)
    assert [error.number for error in during.errors] == [3, 2, 1]
    for unit in units:
        pretend_solved(store, unit)
    after = run_status(scenario, store)
    assert (after.left, after.cpu_hours_left) == (0, 0.0)
    assert json.loads(json.dumps(after.as_data()))["errors"][0]["reason"] == "crashed: SIGSEGV"


def test_after_an_interruption_it_says_what_is_kept_and_that_nobody_goes_on(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...]
) -> None:
    first, second = Journal(store.folder / "journal", "7-a"), Journal(store.folder / "journal", "8-b")
    first.started(units[0].digest)
    first.stored(units[0].digest, cpu_s=3600.0, wall_s=1.0, kept=True, solves=30)
    pretend_solved(store, units[0])
    first.started(units[1].digest)
    first.progress(units[1].digest, cpu_s=600.0, wall_s=1.0, solves=5, known=0)
    first.progress(units[1].digest, cpu_s=900.0, wall_s=1.0, solves=7, known=0)
    first.ended(units[1].digest)
    with the_local_driver(store.folder):
        assert run_status(scenario, store).driver is None, "who asks is not who drives"
    status = run_status(scenario, store)
    assert (status.solved, status.left, status.begun, status.solves, status.driver) == (1, 5, 1, 37, None)
    assert status.cpu_hours_spent == pytest.approx(1.25) and status.cpu_hours_left == pytest.approx(4.75)
    second.started(units[1].digest)
    second.progress(units[1].digest, cpu_s=1000.0, wall_s=1.0, solves=9, known=6)
    assert run_status(scenario, store).solves == 39
    assert [entry.event for entry in read_journal(store.folder / "journal")].count("progress") == 2


def test_parts_of_other_plans_do_not_count(store: UnitStore, scenario: Scenario, units: tuple[Unit, ...]) -> None:
    data = units[0].as_data()
    data["strategy"]["seed"] = 77
    pretend_solved(store, Unit.from_data(data))
    assert run_status(scenario, store).left == 6


def test_a_damaged_pack_in_quarantine_counts(store: UnitStore, scenario: Scenario) -> None:
    store.quarantine("0" * 64, "there is no such part, so nothing is moved")
    assert run_status(scenario, store).quarantined == 0
    pack = store.folder / "packs" / f"{'1' * 64}.pack"
    pack.parent.mkdir(parents=True)
    pack.write_bytes(b"damaged")
    assert len(store.set_aside_damaged_packs()) == 1
    assert run_status(scenario, store).quarantined == 1


def test_a_line_cut_short_is_left_out(store: UnitStore, units: tuple[Unit, ...]) -> None:
    journal = Journal(store.folder / "journal", "7-a")
    journal.started(units[0].digest)
    journal.stored(units[0].digest, 1.0, 1.0, True)
    (file,) = (store.folder / "journal").iterdir()
    file.write_text(file.read_text()[:-9])
    assert [entry.event for entry in read_journal(file.parent)] == ["start"]


def test_status_needs_no_dask() -> None:
    code = "import sys, gaitflow.execute.status; print({'dask', 'distributed', 'casadi'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "dask" not in done.stdout and "distributed" not in done.stdout


def test_jobs_by_state_and_where_their_logs_are(store: UnitStore, scenario: Scenario) -> None:
    (store.folder / "cluster").mkdir(parents=True)
    (store.folder / "logs").mkdir()
    states = [
        ("driver", "RUNNING", "None"),
        ("a-0", "RUNNING", "None"),
        *[(f"a-{i}", "PENDING", "Priority") for i in (1, 2)],
    ]
    jobs = [
        {"id": str(i), "name": "gaitflow", "state": state, "reason": reason, "role": role}
        for i, (role, state, reason) in enumerate(states)
    ]
    (store.folder / "cluster" / "jobs.json").write_text(json.dumps({"time": time.time(), "jobs": jobs}))
    status = run_status(scenario, store)
    assert status.jobs == JobCounts({"RUNNING": 1}, {"RUNNING": 1, "PENDING": 2}, {"Priority": 2})
    assert str(status.jobs) == "driver 1 running; workers 2 pending, 1 running; waiting for Priority"
    assert status.logs == str(store.folder / "logs")
    assert json.loads(json.dumps(status.as_data()))["jobs"]["workers"] == {"RUNNING": 1, "PENDING": 2}


def test_without_slurm_the_jobs_are_unknown_and_the_rest_is_told(
    store: UnitStore, scenario: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert (run_status(scenario, store).jobs, run_status(scenario, store).logs) == (None, None)
    (store.folder / "cluster").mkdir(parents=True)
    monkeypatch.setenv("PATH", "/nowhere")
    status = run_status(scenario, store)
    assert status.jobs is None and status.left == 6
