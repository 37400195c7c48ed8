"""How far a run is: units that are done, solves inside the others, and about how long the rest will take."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gaitflow.execute.expected_solves import ExpectedSolves
from gaitflow.execute.receipt import Receipt
from gaitflow.store.journal import Entry, latest
from gaitflow.store.units import Unit

READ_EVERY_S = 1.0  # the journal
READING_SHARE = 0.02  # of the time that goes into that: files of a thousand workers on a shared disk take a while
FEWEST_SOLVES = 50  # of the start, and as many again from which on their rate means something


@dataclass(frozen=True)
class RunState:
    """Counts of units: `total` = `solved` + `failed` + `left`; `found` were stored before. `notes` are news.

    `solves` are those of units that were not stored before, also of those `in_work`; `solves_left` and `seconds_left`
    are estimates, None while nothing is known.
    """

    total: int
    found: int
    solved: int
    failed: int
    notes: tuple[str, ...] = ()
    in_work: int = 0
    solves: int = 0
    solves_left: float | None = None
    seconds_left: float | None = None

    @property
    def left(self) -> int:
        """Units that are neither solved nor given up."""
        return self.total - self.solved - self.failed


OnEvent = Callable[[RunState], None]


class Count:
    """The state of a run, from its receipts and the journal of its solvers; `on_event` hears of every change."""

    def __init__(
        self, units: Sequence[Unit], stored: frozenset[str], failed: set[str], journal: Path, on_event: OnEvent
    ) -> None:
        self._left = {unit.digest: unit for unit in units if unit.digest not in stored}
        found = len({unit.digest for unit in units}) - len(self._left)
        gone = len(failed & {unit.digest for unit in units})
        self._journal, self._on_event = journal, on_event
        self._start, self._next_look = time.time(), 0.0
        self._expected: ExpectedSolves | None = None
        self._solved_now = 0  # in units that are done, without what was known
        self._warm: tuple[float, int] | None = None  # when there were how many new solves, at the end of the start
        self.state = RunState(found + len(self._left), found, found - gone, gone)
        self.tell()

    def tell(self, *notes: str) -> None:
        """Say how far the run is, with news."""
        self._on_event(replace(self.state, notes=notes))

    def add(self, receipt: Receipt) -> None:
        """One unit more came to its end."""
        name, state = receipt.unit[:12], self.state
        notes = [f"unit {name}: {reason}" for reason in receipt.attempts]
        if receipt.outcome == "failed":
            notes.append(f"unit {name}: given up: {receipt.error}")
        failed = int(receipt.outcome == "failed")
        self.state = replace(state, solved=state.solved + 1 - failed, failed=state.failed + failed)
        unit = self._left.pop(receipt.unit, None)
        if unit is not None and receipt.solves:
            self._expectation().finished(unit, receipt.solves)
            self._solved_now += receipt.solves - receipt.known
        if self._due() or not self.state.left:  # not at each: a driver of many workers would do little else
            self._look()
        self.tell(*notes)

    def look(self) -> None:
        """Look now and then how far the units in work are."""
        if self._due():
            before = self.state
            self._look()
            if self.state != before:
                self.tell()

    def _due(self) -> bool:
        return time.monotonic() >= self._next_look

    def _look(self) -> None:
        begin = time.monotonic()
        self._read()
        self._next_look = begin + max(READ_EVERY_S, (time.monotonic() - begin) / READING_SHARE)

    def _read(self) -> None:
        entries = [one for one in latest(self._journal) if one.time >= self._start and one.unit in self._left]
        in_work = {one.unit: one for one in sorted(entries, key=lambda one: one.solves) if one.event != "ended"}
        self.state = replace(self.state, in_work=len(in_work))
        if self._expected is not None or any(one.solves for one in in_work.values()):
            self._estimate(in_work)
        elif done := self.state.total - self.state.left - self.state.found:
            seconds = (time.time() - self._start) / done * self.state.left
            self.state = replace(self.state, seconds_left=seconds)

    def _estimate(self, in_work: Mapping[str, Entry]) -> None:
        expected = self._expectation()
        solves = {digest: one.solves for digest, one in in_work.items()}
        left = expected.left(self._left, solves)
        new = self._solved_now + sum(one.solves - one.known for one in in_work.values())
        rate = self._rate(time.monotonic(), new)
        seconds = left / rate if rate else None
        done = expected.solved + sum(solves.values())
        self.state = replace(self.state, solves=done, solves_left=left, seconds_left=seconds)

    def _rate(self, now: float, new: int) -> float | None:
        """New solves a second without the first few, while problems are derived and nothing is warm."""
        if self._warm is None:
            self._warm = (now, new) if new >= FEWEST_SOLVES else None
            return None
        since, before = self._warm
        return (new - before) / (now - since) if new - before >= FEWEST_SOLVES else None

    def _expectation(self) -> ExpectedSolves:
        # Not before something is solved: it takes CasADi, which a run's driver needs for nothing else.
        if self._expected is None:
            self._expected = ExpectedSolves.of_plan(list(self._left.values()))
        return self._expected
