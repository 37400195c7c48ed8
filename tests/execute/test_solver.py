"""The solver process against solvers that throw, hang, die, and parents that die."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from gaitflow.config.scenario import Scenario
from gaitflow.execute.receipt import Receipt
from gaitflow.execute.solver import Solver, SolverClosed, longest_unit_s, time_limit
from gaitflow.store.journal import read_journal, unended
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units
from gaitflow.tables.provenance import read_record
from gaitflow.tables.solutions import table_to_solutions

made: list[Solver] = []


@pytest.fixture(autouse=True)
def close_solvers() -> Iterator[None]:
    yield
    while made:
        made.pop().close()


def solver(name: str) -> Solver:
    made.append(Solver(f"fakes:{name}"))
    return made[-1]


def statuses(store: UnitStore, unit: Unit) -> set[tuple[str, str]]:
    return {(row.status, row.solver_status) for row in table_to_solutions(store.read(unit), unit.scenario.as_data())}


def test_units_are_solved_and_stored_and_chatter_stays_out(store: UnitStore, units: tuple[Unit, ...]) -> None:
    worker = solver("steady")
    assert worker.run(units[0], store) == Receipt(units[0].digest, "solved")
    assert worker.run(units[1], store).outcome == "solved"
    assert worker.run(units[0], store).outcome == "already"
    assert statuses(store, units[0]) == {("solved", "Solve_Succeeded")}
    entries = read_journal(store.folder / "journal")
    assert [(e.event, e.unit) for e in entries] == [(e, u.digest) for u in units[:2] for e in ("start", "stored")]
    assert entries[1].kept and entries[1].wall_s > 0


@pytest.mark.parametrize(
    ("name", "reason", "detail"),
    [
        ("throws", "RuntimeError: Uncaught error in Bonmin", ""),
        ("dies", "crashed: SIGSEGV", "last words"),
        ("leaves_tasks_out", "ValueError: the solver's rows and the unit's tasks differ", ""),
    ],
)
def test_a_faulty_solver_is_given_up_after_three_attempts(
    store: UnitStore, units: tuple[Unit, ...], name: str, reason: str, detail: str
) -> None:
    worker = solver(name)
    receipt = worker.run(units[0], store)
    assert receipt.outcome == "failed" and len(receipt.attempts) == 3
    assert all(attempt.startswith(reason) for attempt in receipt.attempts)
    assert all(detail in attempt.detail for attempt in store.attempts.of(units[0]))
    assert [entry.event for entry in read_journal(store.folder / "journal")] == ["start", "ended"] * 3
    ((status, text),) = statuses(store, units[0])
    assert status == "failed" and text.startswith(reason) and text.endswith(" x3")
    assert worker.run(units[0], store).outcome == "already"


def test_a_hanging_solver_is_killed_and_given_up(store: UnitStore, units: tuple[Unit, ...], fakes: Path) -> None:
    for _ in range(2):
        store.attempts.record(units[0], "crashed: SIGSEGV")
    assert solver("hangs").run(units[0], store, limit_s=5.0).outcome == "failed"
    assert statuses(store, units[0]) == {("failed", "crashed: SIGSEGV x2, hung: no answer in 5 s")}
    pids = [int(mark.name.split("-")[1]) for mark in fakes.glob("hangs-*")]
    assert len(pids) >= 1 and not any(alive(pid) for pid in pids)


def test_a_crash_costs_one_attempt_and_the_next_one_solves(store: UnitStore, units: tuple[Unit, ...]) -> None:
    receipt = solver("dies_once").run(units[0], store)
    assert receipt.outcome == "solved" and receipt.attempts == ("crashed: SIGSEGV",)
    assert statuses(store, units[0]) == {("solved", "Solve_Succeeded")}


def test_attempts_of_earlier_runs_count(store: UnitStore, units: tuple[Unit, ...]) -> None:
    for _ in range(2):
        store.attempts.record(units[0], "hung")
    receipt = solver("dies").run(units[0], store)
    assert receipt.outcome == "failed" and len(receipt.attempts) == 1
    assert statuses(store, units[0]) == {("failed", "hung x2, crashed: SIGSEGV")}


def test_closing_interrupts_a_solve_without_blaming_the_unit(
    store: UnitStore, units: tuple[Unit, ...], fakes: Path
) -> None:
    before, worker = set(fakes.glob("hangs-*")), solver("hangs")
    threading.Thread(target=lambda: (wait_for_mark(fakes, before), worker.close())).start()
    with pytest.raises(SolverClosed):
        worker.run(units[0], store)
    assert store.attempts.count(units[0]) == 0 and not store.has(units[0])
    assert [entry.event for entry in read_journal(store.folder / "journal")] == ["start", "ended"]
    with pytest.raises(SolverClosed):
        worker.run(units[1], store)


def test_a_solver_ended_by_a_batch_system_does_not_blame_the_unit(
    store: UnitStore, units: tuple[Unit, ...], fakes: Path
) -> None:
    before = set(fakes.glob("hangs-*"))
    worker = solver("hangs")

    def end() -> None:
        while not (new := set(fakes.glob("hangs-*")) - before):
            time.sleep(0.05)
        os.kill(int(new.pop().name.removeprefix("hangs-")), signal.SIGTERM)

    thread = threading.Thread(target=end)
    thread.start()
    with pytest.raises(SolverClosed, match="asked to end"):
        worker.run(units[0], store)
    thread.join()
    assert store.attempts.count(units[0]) == 0 and not store.has(units[0])
    assert [entry.event for entry in read_journal(store.folder / "journal")] == ["start", "ended"]


def test_a_store_that_cannot_be_written_stops_the_run(store: UnitStore, units: tuple[Unit, ...]) -> None:
    store.folder.mkdir(parents=True)
    (store.folder / "units").write_text("in the way")
    receipt = solver("steady").run(units[0], store)
    assert receipt.outcome == "refused" and f"{units[0].digest}.parquet: cannot be written" in receipt.error
    assert store.attempts.count(units[0]) == 0


def test_a_full_disk_stops_the_run(tmp_path: Path, units: tuple[Unit, ...]) -> None:
    mount = tmp_path / "small"
    mount.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(mount)], capture_output=True)
    if done.returncode:
        pytest.skip("mounting a small disk is not permitted here")
    try:
        (mount / "ballast").write_bytes(b"x" * 53_000)
        store = UnitStore(mount / "run")
        receipt = solver("steady").run(units[0], store)
        assert receipt.outcome == "refused" and "No space left" in receipt.error and "free some space" in receipt.error
        assert store.solved() == frozenset() and list(store.folder.rglob("*.tmp")) == []
        (mount / "ballast").unlink()
        assert solver("steady").run(units[0], store).outcome == "solved"
    finally:
        made.pop().close()
        subprocess.run(["umount", "-l", str(mount)], check=True)


def test_other_code_than_the_plan_s_is_refused(store: UnitStore, units: tuple[Unit, ...]) -> None:
    data = units[0].as_data()
    data["solver"]["code"] = "0" * 64
    receipt = solver("steady").run(Unit.from_data(data), store)
    assert receipt.outcome == "refused" and "start the run again with one version" in receipt.error


def test_the_solver_process_dies_with_a_killed_parent(
    tmp_path: Path, units: tuple[Unit, ...], fakes: Path, checkout: Path
) -> None:
    before = set(fakes.glob("hangs-*"))
    code = (
        "import json, sys; from pathlib import Path; from gaitflow.execute.solver import Solver;"
        "from gaitflow.store.units import Unit; from gaitflow.store.parts import UnitStore;"
        "Solver('fakes:hangs').run(Unit.from_data(json.load(sys.stdin)), UnitStore(Path(sys.argv[1])))"
    )
    parent = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdin=subprocess.PIPE, cwd=checkout)
    assert parent.stdin is not None
    parent.stdin.write(json.dumps(units[0].as_data()).encode())
    parent.stdin.close()
    child = wait_for_mark(fakes, before)
    assert alive(child)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    deadline = time.monotonic() + 5
    while alive(child) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not alive(child)
    assert not (tmp_path / "attempts").exists()
    assert {unit: len(files) for unit, files in unended(tmp_path / "journal").items()} == {units[0].digest: 1}


def test_time_limits_follow_the_work_and_are_bounded(scenario: Scenario) -> None:
    def limit(**strategy: object) -> float:
        data = scenario.as_data()
        data["strategy"] |= strategy
        return time_limit(plan_units(Scenario.from_data(data, "test"))[0])

    fixed = {"name": "fixed_gait", "pattern": "0110/1100", "restarts": 2}
    assert limit(**fixed, solve_time_limit=5.0) == 60 + 3 * 5
    assert limit(**fixed, solve_time_limit=5.0, tasks_per_unit=2) == 60 + 2 * 3 * 5
    assert limit(name="bonmin", restarts=7, solve_time_limit=10.0) == 60 + 5 * 10
    assert limit(solve_time_limit=20.0) == 3600


def wait_for_mark(fakes: Path, before: set[Path]) -> int:
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        for mark in set(fakes.glob("hangs-*")) - before:
            return int(mark.name.split("-")[1])
        time.sleep(0.02)
    raise AssertionError("the solver never started")


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_the_real_solver_solves_and_its_record_tells_how(scenario: Scenario, store: UnitStore) -> None:
    data = scenario.as_data()
    data["transcription"]["knots_per_phase"] = 4
    data["strategy"] |= {"name": "fixed_gait", "pattern": "0110/1100"}
    unit = plan_units(Scenario.from_data(data, "test"))[1]
    made.append(Solver())
    assert made[-1].run(unit, store).outcome == "solved"
    (row,) = table_to_solutions(store.read(unit), unit.scenario.as_data())
    assert row.status == "solved" and row.violation <= 1e-6 and row.cost > 0 and row.trajectory is not None
    record = read_record(pq.read_metadata(store.path(unit.digest)).metadata, "part")
    assert record["solver_options"]["ipopt"]["tol"] <= 1e-6


def test_a_process_asked_to_end_finishes_the_part_it_writes(
    store: UnitStore, units: tuple[Unit, ...], checkout: Path
) -> None:
    """The child asks itself to end in the middle of its write, so that no luck is needed to hit it."""
    code = (
        "import os, signal, sys; from pathlib import Path; import fakes;"
        "from gaitflow.store.parts import UnitStore; from gaitflow.execute.solver_process import main;"
        "write = UnitStore.write;"
        "UnitStore.write = lambda *a: (os.kill(os.getpid(), signal.SIGTERM), write(*a))[1];"
        "main(['--parent', str(os.getppid()), '--solve', 'fakes:steady'])"
    )
    request = json.dumps({"unit": units[0].as_data(), "store": str(store.folder), "solver": "7-a"}) + "\n"
    done = subprocess.run([sys.executable, "-c", code], input=request, text=True, cwd=checkout, timeout=60)
    assert done.returncode == -signal.SIGTERM
    assert store.validate(units[0]) is None and store.has(units[0])
    assert [entry.event for entry in read_journal(store.folder / "journal")] == ["start", "stored"]


def test_the_longest_unit_of_many_builds_one_scenario_a_kind(scenario: Scenario) -> None:
    data = scenario.as_data()
    data["strategy"] |= {
        "name": "fixed_gait", "pattern": "0110/1100", "restarts": 2, "solve_time_limit": 5.0, "tasks_per_unit": 2
    }  # fmt: skip
    data["tasks"]["axes"]["speed"]["count"] = 5
    units = plan_units(Scenario.from_data(data, "test"))
    assert {len(unit.tasks) for unit in units} == {1, 2}
    assert longest_unit_s(units) == 60 + 2 * 3 * 5
    assert sum("scenario" in vars(unit) for unit in units) == 2
    assert longest_unit_s(()) == 0
