"""A worker's handle on its solver process: starts it, feeds it, and outlives its crashes and hangs."""

from __future__ import annotations

import math
import secrets
import threading
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace

from gaitflow.execute.line_process import LineProcess, Lost
from gaitflow.execute.receipt import Receipt
from gaitflow.execute.solver_process import SOLVE
from gaitflow.files import WriteError
from gaitflow.store.attempts import MAX_ATTEMPTS, failed_solutions
from gaitflow.store.journal import Journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

MODULE = "gaitflow.execute.solver_process"
START_UP_S = 60.0
LONGEST_UNIT_S = 3600.0
STORING_S = 2.0  # a process asked to end may first finish the part that it is writing
ASKED_TO_END = "crashed: SIGTERM"  # no solver ends like this by itself, so it is not the unit's fault


class SolverClosed(Exception):
    """The worker is being closed: this says nothing about the unit, which has to be solved elsewhere."""


class Solver:
    """One solver process, restarted when it is lost. `run` may be called by one thread, `close` by any."""

    def __init__(self, solve: str = SOLVE) -> None:
        self._solve = solve
        self._process: LineProcess | None = None
        self._name = ""  # of that process in the journal
        self._output = ""  # what it wrote in the last attempt
        self._in_work: tuple[Journal, str] | None = None
        self._closed = False
        self._lock = threading.Lock()
        self._starter = ThreadPoolExecutor(1, "solver-starter")  # a thread that stays, as `LineProcess` needs it

    def run(self, unit: Unit, store: UnitStore, limit_s: float | None = None) -> Receipt:
        """Have a unit solved and stored, at most MAX_ATTEMPTS times over all runs; then it is stored as failed.

        Raises SolverClosed when `close` was called meanwhile.
        """
        lost: list[str] = []
        limit = time_limit(unit) if limit_s is None else limit_s
        try:
            while store.attempts.count(unit) < MAX_ATTEMPTS:
                receipt = self._attempt(unit, store, limit)
                if receipt.outcome != "raised":
                    return replace(receipt, attempts=tuple(lost))
                lost.append(receipt.error)
                store.attempts.record(unit, receipt.error, self._output)
            attempts = store.attempts.of(unit)
            rows = failed_solutions(unit, attempts)
            kept = store.write(unit, rows, {})
        except WriteError as error:
            return Receipt(unit.digest, "refused", str(error.args[-1]), tuple(lost))
        return Receipt(unit.digest, "failed" if kept else "already", rows[0].solver_status, tuple(lost))

    def close(self) -> None:
        """End the solver process; a unit in flight is given up and raises SolverClosed in the thread that runs it."""
        with self._lock:
            self._closed = True
            if self._process is not None:  # whoever waits for its answer tidies up
                self._process.terminate(STORING_S)
            self._note_end()
        self._starter.shutdown(wait=False)

    def _attempt(self, unit: Unit, store: UnitStore, limit: float) -> Receipt:
        request = {"unit": unit.as_data(), "store": str(store.folder.resolve())}
        try:
            process = self._started(unit, store)
            receipt = Receipt.from_data(process.ask(request | {"solver": self._name}, limit))
            if receipt.outcome == "raised":
                self._output = _output(process)
            with self._lock:
                self._note_end(stored=receipt.outcome in ("solved", "already"))
            return receipt
        except Lost as lost:
            with self._lock:
                ending = self._end()
                self._note_end()
                if self._closed:
                    raise SolverClosed("the worker is closing") from None
            if ending == ASKED_TO_END and not str(lost):
                raise SolverClosed("the solver was asked to end, as Slurm asks every process of a job") from None
            return Receipt(unit.digest, "raised", str(lost) or ending)

    def _started(self, unit: Unit, store: UnitStore) -> LineProcess:
        with self._lock:
            if self._closed:
                raise SolverClosed("the worker is closing")
            if self._process is None or not self._process.alive:
                self._process = self._starter.submit(LineProcess, MODULE, ["--solve", self._solve]).result()
                self._name = f"{self._process.pid}-{secrets.token_hex(4)}"
            self._in_work = Journal(store.folder / "journal", self._name), unit.digest
            return self._process

    def _end(self) -> str:
        """Kill the process; what ended it when it was not us."""
        process, self._process = self._process, None
        if process is None:
            return "lost"
        ending = process.end()
        self._output = _output(process)
        return ending

    def _note_end(self, stored: bool = False) -> None:
        """Write down, once, that the unit in work came to an end that we saw: its worker was not lost."""
        in_work, self._in_work = self._in_work, None
        if in_work is not None and not stored:  # else the process itself has written so
            journal, unit = in_work
            with suppress(OSError):  # a full disk: the unit counts as one more lost worker, which decides nothing
                journal.ended(unit)


def time_limit(unit: Unit) -> float:
    """Seconds after which a unit counts as hung: its solver calls at their limit, 60 s to start, an hour at most."""
    scenario = unit.scenario
    strategy, legs, phases = scenario.strategy, len(scenario.robot.legs), scenario.transcription.phases
    _, parts = strategy.part or (0, 1)
    calls = {
        "patterns": math.ceil(2 ** (legs * phases) / parts) * (1 + strategy.restarts),
        "guided": 2 * strategy.budget * (1 + strategy.restarts),
        "fixed_gait": 1 + strategy.restarts,
        "bonmin": len(unit.seeds or (0,)),
    }[strategy.name]
    return min(LONGEST_UNIT_S, START_UP_S + len(unit.tasks) * calls * strategy.solve_time_limit)


def longest_unit_s(units: Iterable[Unit]) -> float:
    """The longest time that any of these units may take [s]; 0 without units."""
    # Units of one kind have one limit. Asking each of 10^5 would build as many scenarios.
    kinds = {(unit.problem, unit.strategy, len(unit.tasks), len(unit.seeds or ())): unit for unit in units}
    return max(map(time_limit, kinds.values()), default=0.0)


def _output(process: LineProcess) -> str:
    return "\n".join(line for line in process.said() if not line.startswith("Extension modules:"))  # of a traceback
