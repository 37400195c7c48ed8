from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from gaitflow.config.scenario import Scenario, Strategy
from gaitflow.execute import count as module
from gaitflow.execute.count import Count, RunState
from gaitflow.execute.expected_solves import ExpectedSolves, solves_per_task
from gaitflow.execute.receipt import Receipt
from gaitflow.search.bound import ruled_out
from gaitflow.search.exhaustive import candidate_patterns
from gaitflow.store.journal import Journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_exhaustive, plan_units


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Moves the clock of the count on by some seconds."""
    now = [1000.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: now[0])

    def wait(seconds: float) -> None:
        now[0] += seconds

    return wait


def test_solves_inside_units_are_told_before_any_unit_is_done(
    store: UnitStore, units: tuple[Unit, ...], clock: Callable[[float], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Six units of one task, of which each takes 30 solves."""
    told: list[RunState] = []
    monkeypatch.setattr(module, "FEWEST_SOLVES", 10)
    folder = store.folder / "journal"
    Journal(folder, "6-killed").progress(units[0].digest, 9.0, 9.0, solves=25, known=0)
    one, other = Journal(folder, "7-a"), Journal(folder, "8-b")
    count = Count(units, frozenset(), set(), folder, told.append)
    assert (told[-1].solves, told[-1].in_work, told[-1].solves_left) == (0, 0, None), "a killed solver is not at work"
    for journal, unit in zip((one, other), units, strict=False):
        journal.started(unit.digest)
    count.look()
    assert (told[-1].in_work, told[-1].seconds_left) == (2, None)
    one.progress(units[0].digest, 0.1, 0.1, solves=1, known=0)
    clock(1.0)
    count.look()
    assert told[-1].solves == 1 and told[-1].solves_left is not None and told[-1].seconds_left is None
    one.progress(units[0].digest, 2.0, 2.0, solves=11, known=0)
    other.progress(units[1].digest, 2.0, 2.0, solves=20, known=10)
    clock(10.0)
    count.look()
    state = told[-1]
    assert state.solves == 31 and state.solves_left == pytest.approx(6 * 30 - 31)
    assert state.seconds_left is None, "that was the start"
    one.progress(units[0].digest, 4.0, 4.0, solves=21, known=0)
    other.progress(units[1].digest, 4.0, 4.0, solves=25, known=10)
    clock(5.0)
    count.look()
    assert told[-1].seconds_left == pytest.approx((6 * 30 - 46) * 5 / 15), "those known before took no time"


def test_finished_units_correct_what_was_foretold(
    store: UnitStore, units: tuple[Unit, ...], clock: Callable[[float], None]
) -> None:
    told: list[RunState] = []
    count = Count(units, frozenset(), set(), store.folder / "journal", told.append)
    for unit in units[:4]:
        count.add(Receipt(unit.digest, "solved", solves=60))
        clock(10.0)
    assert told[-1].solved == 4 and told[-1].solves == 240
    assert told[-1].solves_left == pytest.approx(2 * (30 + 240) / 5)
    assert told[-1].seconds_left == pytest.approx(told[-1].solves_left * 30 / 180)
    count.add(Receipt(units[4].digest, "failed", "crashed: SIGSEGV x3", ("crashed: SIGSEGV",) * 3))
    assert (told[-1].failed, told[-1].left) == (1, 1)
    assert told[-1].notes[-1] == f"unit {units[4].digest[:12]}: given up: crashed: SIGSEGV x3"
    count.add(Receipt(units[5].digest, "already"))
    assert (told[-1].left, told[-1].solves_left) == (0, 0.0)


def test_the_time_left_forgets_how_slow_the_start_was(
    store: UnitStore, units: tuple[Unit, ...], clock: Callable[[float], None]
) -> None:
    told: list[RunState] = []
    count = Count(units, frozenset(), set(), store.folder / "journal", told.append)
    for seconds, unit in zip((100.0, 10.0, 10.0, 0.0), units, strict=False):
        count.add(Receipt(unit.digest, "solved", solves=40))
        clock(seconds)
    assert told[-1].solves_left is not None
    assert told[-1].seconds_left == pytest.approx(told[-1].solves_left * 20 / 80)


def test_how_often_the_journals_are_read_does_not_depend_on_the_receipts(
    store: UnitStore, units: tuple[Unit, ...], clock: Callable[[float], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With hundreds of workers a driver that reads all their journals at every receipt does nothing else."""
    reads: list[Path] = []
    latest = module.latest
    monkeypatch.setattr(module, "latest", lambda folder: reads.append(folder) or latest(folder))
    told: list[RunState] = []
    count = Count(units, frozenset(), set(), store.folder / "journal", told.append)
    for unit in units[:5]:
        count.add(Receipt(unit.digest, "solved", solves=60))
    assert len(reads) == 1 and [state.left for state in told] == [6, 5, 4, 3, 2, 1]
    clock(1.0)
    count.look()
    assert len(reads) == 2 and told[-1].solves == 300
    count.add(Receipt(units[5].digest, "solved", solves=60))
    assert (told[-1].left, told[-1].solves, told[-1].solves_left) == (0, 360, 0.0), "the last word is exact"


def test_without_solves_the_units_tell_the_time(store: UnitStore, units: tuple[Unit, ...]) -> None:
    told: list[RunState] = []
    count = Count(units, frozenset({units[0].digest}), set(), store.folder / "journal", told.append)
    assert (told[-1].found, told[-1].left, told[-1].seconds_left) == (1, 5, None)
    count.add(Receipt(units[1].digest, "solved"))
    assert told[-1].seconds_left is not None and told[-1].seconds_left < 4.0


def test_solves_are_foretold_from_what_the_screen_leaves(scenario: Scenario, units: tuple[Unit, ...]) -> None:
    task = units[0].tasks[0]
    left = [one for one in candidate_patterns(scenario, task) if ruled_out(scenario, one, task, math.inf) is None]
    assert solves_per_task(units[0]) == pytest.approx(1.25 * len(left))
    guided = scenario.model_copy(update={"strategy": Strategy(name="guided", budget=100)})
    assert solves_per_task(plan_units(guided)[0]) == 40.0
    restarts = scenario.model_copy(update={"strategy": Strategy(name="bonmin", restarts=7)})
    assert [solves_per_task(unit) for unit in plan_units(restarts)[:2]] == [5.0, 2.0]
    parts = plan_exhaustive(scenario, {task: 1e-9}, 2)
    assert solves_per_task(parts[0]) < solves_per_task(units[0]) / 2, "a known motion rules out most"
    assert ExpectedSolves.of_plan(()).of(units[0]) == 0.0
