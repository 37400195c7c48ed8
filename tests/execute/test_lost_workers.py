"""Units that take their worker with them: nobody is left to record an attempt."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager

import pytest
from distributed import Client

from gaitflow.config.scenario import Scenario
from gaitflow.dataset import load_solutions
from gaitflow.dataset.collect import collect
from gaitflow.execute.local import local_client
from gaitflow.execute.run import RunState, run_units
from gaitflow.execute.status import run_status
from gaitflow.store.journal import Journal, read_journal, unended
from gaitflow.store.lost_workers import MAX_LOST_WORKERS, give_up_after_lost_workers
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

Open = Callable[[], AbstractContextManager[Client]]


def lose_workers(store: UnitStore, unit: Unit, times: int) -> None:
    for number in range(times):
        Journal(store.folder / "journal", f"{number}-{unit.digest[:8]}").started(unit.digest)


def starts(store: UnitStore) -> Counter[str]:
    return Counter(entry.unit for entry in read_journal(store.folder / "journal") if entry.event == "start")


def test_a_unit_is_given_up_only_when_it_lost_many_workers(store: UnitStore, units: tuple[Unit, ...]) -> None:
    lose_workers(store, units[0], MAX_LOST_WORKERS)
    lose_workers(store, units[1], MAX_LOST_WORKERS - 1)
    give_up_after_lost_workers(store, units[1:])
    assert store.attempts.given_up() == set(), "it looks only at what it is asked about"
    give_up_after_lost_workers(store, units)
    assert store.attempts.given_up() == {units[0].digest}
    (attempt,) = store.attempts.of(units[0])
    assert attempt.reason == "its worker was lost 8 times: out of memory?"
    assert unended(store.folder / "journal").keys() == {units[1].digest}
    give_up_after_lost_workers(store, units)
    assert len(store.attempts.of(units[0])) == 1


def test_a_run_does_not_try_what_took_its_workers_before(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...], open_client: Open
) -> None:
    """Also when the driver itself was killed each time, so that no run has seen all of it."""
    lose_workers(store, units[0], MAX_LOST_WORKERS)
    lose_workers(store, units[1], MAX_LOST_WORKERS - 1)
    before = starts(store)
    states: list[RunState] = []
    last = run_units(units, store, open_client, states.append, solve="fakes:steady")
    assert (last.solved, last.failed, last.left) == (5, 1, 0)
    assert starts(store) - before == Counter(unit.digest for unit in units[1:])
    notes = [note for state in states for note in state.notes]
    assert notes == [f"unit {units[0].digest[:12]}: given up: its worker was lost 8 times: out of memory?"]
    frame = load_solutions(collect(store, scenario)).frame()
    failed = frame[frame["status"] == "failed"]
    assert failed["solver_status"].tolist() == ["its worker was lost 8 times: out of memory?"]
    assert run_status(scenario, store).failed == 1


def test_a_given_up_unit_can_be_tried_again(store: UnitStore, units: tuple[Unit, ...], open_client: Open) -> None:
    """As any other one: without its attempts and its part."""
    lose_workers(store, units[0], MAX_LOST_WORKERS)
    assert run_units(units[:1], store, open_client, solve="fakes:steady").failed == 1
    for attempt in (store.attempts.folder / units[0].digest).iterdir():
        attempt.unlink()
    store.path(units[0].digest).unlink()
    assert run_units(units[:1], store, open_client, solve="fakes:steady").solved == 1


@pytest.mark.slow
def test_a_unit_that_kills_its_workers_ends_as_failed_and_the_rest_is_solved_once(
    store: UnitStore, scenario: Scenario, units: tuple[Unit, ...]
) -> None:
    last = run_units(units, store, local_client, solve="fakes:kills_its_worker")
    assert (last.solved, last.failed, last.left) == (5, 1, 0)
    (poison,) = store.attempts.given_up()
    (attempt,) = store.attempts.of(next(unit for unit in units if unit.digest == poison))
    assert attempt.reason.startswith("its worker was lost") and attempt.reason.endswith("times: out of memory?")
    stored = Counter(e.unit for e in read_journal(store.folder / "journal") if e.event == "stored")
    assert stored == Counter(unit.digest for unit in units if unit.digest != poison)
    tried = starts(store)[poison]
    assert MAX_LOST_WORKERS <= tried < 2 * MAX_LOST_WORKERS
    frame = load_solutions(collect(store, scenario)).frame()
    assert (frame["status"] == "failed").sum() == 1
