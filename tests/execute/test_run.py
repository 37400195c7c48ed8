from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from distributed import Client
from distributed.comm import CommClosedError

from gaitflow.config.scenario import Scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.execute.run import RunFailed, RunState, RunStopped, _give_solvers, run_units
from gaitflow.execute.status import run_status
from gaitflow.store.journal import read_journal, unended
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

Open = Callable[[], AbstractContextManager[Client]]


def starts(store: UnitStore) -> Counter[str]:
    return Counter(entry.unit for entry in read_journal(store.folder / "journal") if entry.event == "start")


def no_cluster() -> AbstractContextManager[Client]:
    raise AssertionError("nothing is missing, so no cluster is needed")


def test_a_run_solves_all_and_another_one_nothing(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], open_client: Open
) -> None:
    states: list[RunState] = []
    last = run_units(units, store, open_client, states.append, solve="fakes:steady")
    assert (last.total, last.solved, last.failed, last.left) == (6, 6, 0, 0)
    assert list(dict.fromkeys(state.left for state in states)) == [6, 5, 4, 3, 2, 1, 0]
    assert store.solved() == {unit.digest for unit in units}
    again = run_units(units, store, no_cluster, solve="fakes:steady")
    assert (again.found, again.solved) == (6, 6)
    assert starts(store) == Counter(unit.digest for unit in units)


def test_only_what_is_missing_is_solved(store: UnitStore, units: tuple[Unit, ...], open_client: Open) -> None:
    run_units(units[:4], store, open_client, solve="fakes:steady")
    last = run_units(units, store, open_client, solve="fakes:steady", window=1)
    assert (last.found, last.solved) == (4, 6)
    assert starts(store) == Counter(unit.digest for unit in units)


def test_units_that_kill_the_solver_fail_and_the_run_goes_on(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], open_client: Open
) -> None:
    states: list[RunState] = []
    last = run_units(units, store, open_client, states.append, solve="fakes:dies_at_slowest")
    assert (last.solved, last.failed, last.left) == (4, 2, 0)
    notes = [note for state in states for note in state.notes]
    assert sum("given up: crashed: SIGSEGV x3" in note for note in notes) == 2
    frame = load_solutions(collect(store, scenario)).frame()
    failed = frame[frame["status"] == "failed"]
    assert set(failed["solver_status"]) == {"crashed: SIGSEGV x3"} and set(failed["speed"]) == {0.1}
    status = run_status(scenario, store)
    assert (status.solved, status.failed, status.left) == (4, 2, 0)
    assert {error.reason for error in status.errors} == {"crashed: SIGSEGV"}
    assert run_units(units, store, no_cluster).failed == 2, "a unit that was given up is not tried again"


def test_damaged_parts_are_named_and_solved_again(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], open_client: Open
) -> None:
    run_units(units, store, open_client, solve="fakes:steady")
    for unit, keep in ((units[1], 100), (units[4], -1)):
        part = store.path(unit.digest)
        part.write_bytes(part.read_bytes()[:keep])
    states: list[RunState] = []
    last = run_units(units, store, open_client, states.append, solve="fakes:steady")
    assert last.left == 0 and store.validate_all(units) == {}
    notes = [note for state in states for note in state.notes]
    assert sum(unit.digest in note for note in notes for unit in (units[1], units[4])) == 2
    assert {unit: count for unit, count in starts(store).items() if count > 1} == {
        units[1].digest: 2,
        units[4].digest: 2,
    }
    assert run_status(scenario, store).quarantined == 2


def test_a_run_that_cannot_go_on_says_why(store: UnitStore, units: tuple[Unit, ...], open_client: Open) -> None:
    with pytest.raises(RunFailed, match=r"solver cannot be loaded .*install gaitflow"):
        run_units(units, store, open_client, solve="no_such_module:solve")
    store.folder.mkdir(parents=True, exist_ok=True)
    (store.folder / "units").write_text("in the way")
    with pytest.raises(RunFailed, match="cannot be written"):
        run_units(units, store, open_client, solve="fakes:steady")


def drive(scenario: Scenario, store: UnitStore, sleep: float, checkout: Path) -> subprocess.Popen[str]:
    store.folder.mkdir(parents=True, exist_ok=True)
    file = store.folder / "scenario.json"
    file.write_text(json.dumps(scenario.as_data()))
    program = checkout / "tests/execute/drive.py"
    return subprocess.Popen(
        [sys.executable, str(program), str(file), str(store.folder), "fakes:steady"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"FAKE_SLEEP": str(sleep)},
        start_new_session=True,
    )


def wait_until(condition: Callable[[], object], seconds: float = 40.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.02)


def processes_naming(text: str) -> list[str]:
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            environment = (folder / "environ").read_bytes()
            command = (folder / "cmdline").read_bytes().replace(b"\0", b" ")
        except OSError:
            continue
        if text.encode() in environment or text.encode() in command:
            found.append(command.decode(errors="replace"))
    return found


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_a_signal_stops_cleanly_and_the_next_run_goes_on(
    store: UnitStore,
    scenario: Scenario,
    units: tuple[Unit, ...],
    open_client: Open,
    checkout: Path,
    number: signal.Signals,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mark = f"run-{os.getpid()}-{time.time_ns()}"
    monkeypatch.setenv("MARK", mark)
    run = drive(scenario, store, 0.7, checkout)
    wait_until(store.solved)
    if number == signal.SIGINT:
        os.killpg(run.pid, number)  # as a terminal does: everyone in the foreground gets it
    else:
        run.send_signal(number)
    output, _ = run.communicate(timeout=30)
    assert run.returncode == 1
    assert "Traceback" not in output and "Error" not in output
    assert "RunStopped: stopped: " in output and "run the same command again to go on" in output
    wait_until(lambda: processes_naming(mark) == [], 5)
    assert not store.attempts.folder.exists() and list(store.folder.rglob("*.tmp")) == []
    done = {unit: store.path(unit).stat().st_mtime_ns for unit in store.solved()}
    assert 0 < len(done) < len(units)
    assert unended(store.folder / "journal") == {}, "a stop is no lost worker"
    assert run_units(units, store, open_client, solve="fakes:steady").left == 0
    assert {unit: store.path(unit).stat().st_mtime_ns for unit in done} == done
    assert all(starts(store)[unit] == 1 for unit in done)


def test_a_stop_while_the_cluster_closes_is_heard_too(
    store: UnitStore, units: tuple[Unit, ...], open_client: Open
) -> None:
    def stop_at_the_end(state: RunState) -> None:
        if not state.left:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(RunStopped, match="stopped: 6 of 6 units are stored in"):
        run_units(units, store, open_client, stop_at_the_end, solve="fakes:steady")
    assert run_units(units, store, no_cluster, solve="fakes:steady").left == 0


def test_a_stop_that_ends_the_processes_of_a_starting_cluster_is_a_stop(
    store: UnitStore, units: tuple[Unit, ...]
) -> None:
    def ended() -> AbstractContextManager[Client]:
        signal.raise_signal(signal.SIGTERM)
        raise RuntimeError("Nanny failed to start.")

    with pytest.raises(RunStopped, match="stopped: 0 of 6 units are stored in"):
        run_units(units, store, ended, solve="fakes:steady")


@pytest.mark.slow
def test_two_runs_at_once_on_one_store(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], checkout: Path, tmp_path: Path
) -> None:
    runs = [drive(scenario, store, 0.2, checkout) for _ in range(2)]
    outputs = [run.communicate(timeout=60)[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0], outputs
    assert store.solved() == {unit.digest for unit in units} and store.validate_all(units) == {}
    entries = read_journal(store.folder / "journal")
    assert Counter(e.unit for e in entries if e.kept) == Counter(unit.digest for unit in units)
    first_stored = {unit.digest: min(e.time for e in entries if e.unit == unit.digest and e.kept) for unit in units}
    starts = [e for e in entries if e.event == "start"]
    # Between one run's look into the store and its line in the journal the other run may store the unit.
    assert all(e.time < first_stored[e.unit] + 0.1 for e in starts), "a solved unit was solved again"
    assert "Traceback" not in "".join(outputs) and "Warning" not in "".join(outputs)


class Dying:
    """A client whose first `deaths` registrations meet a worker that just died."""

    def __init__(self, deaths: int) -> None:
        self.deaths, self.calls = deaths, 0

    def register_plugin(self, plugin: object) -> None:
        self.calls += 1
        if self.calls <= self.deaths:
            raise CommClosedError("Stream is closed")


def test_a_worker_that_dies_while_the_workers_are_set_up_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitflow.execute.run.POLL_S", 0.0)
    client = Dying(deaths=2)
    _give_solvers(client, "module:function")  # type: ignore[arg-type]
    assert client.calls == 3
    with pytest.raises(RunFailed, match="cannot be set up"):
        _give_solvers(Dying(deaths=1000), "module:function")  # type: ignore[arg-type]
