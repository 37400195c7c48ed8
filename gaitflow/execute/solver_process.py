"""The process that solves: `python -m gaitflow.execute.solver_process`, driven as `line_process` says.

A request is {"unit": ..., "store": folder, "solver": its name in the journal}, its answer a receipt. It solves *and*
stores, so that a part is durable before anyone hears of it.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.execute import line_process
from gaitflow.execute.receipt import Receipt
from gaitflow.files import WriteError
from gaitflow.search.solution import Solution
from gaitflow.solvers.options import IPOPT, IPOPT_WARM
from gaitflow.store.journal import Journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.solve_record import SolveRecord
from gaitflow.store.units import Unit
from gaitflow.tables.solver_code import solver_version

SolveTasks = Callable[[Scenario, Sequence[Task], "tuple[int, ...] | None", "NewSolver"], list[Solution]]
PROGRESS_EVERY_S = 2.0
SOLVE = "gaitflow.search:solve_tasks"


if TYPE_CHECKING:
    from gaitflow.problem import GaitProblem
    from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver, NewSolver


class Refused(Exception):
    """No unit can be solved here, whatever the unit: the run has to stop and say why."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve units from standard input until it ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parent", type=int, required=True, help="process to live and die with")
    parser.add_argument("--solve", default=SOLVE, help="module:function; tests put a faulty solver here")
    options = parser.parse_args(arguments)
    solver_version()  # names the code as it is loaded now, not as it may be edited later

    def answer(request: Mapping[str, Any]) -> str:
        store = UnitStore(Path(request["store"]))
        journal = Journal(store.folder / "journal", request["solver"])
        return solve_unit(Unit.from_data(request["unit"]), store, journal, options.solve).to_line()

    line_process.serve(options.parent, answer)


def solve_unit(unit: Unit, store: UnitStore, journal: Journal, solve: str) -> Receipt:
    """Solve and store one unit unless it is stored; never raises for what the solver or the disk does."""
    if store.has(unit):
        return Receipt(unit.digest, "already")
    try:
        function, solver_options = _load(unit, solve)
        journal.started(unit.digest)
        effort = _Effort(unit.digest, journal)
        record = SolveRecord(store.unfinished(unit.digest), journal.solver)

        def new_solver(problem: GaitProblem, time_limit: float) -> FixedGaitSolver:
            from gaitflow.store.recorded_solver import RecordedSolver  # with CasADi

            return RecordedSolver(problem, time_limit, record, effort.add)

        try:
            solutions = function(unit.scenario, unit.tasks, unit.seeds, new_solver)
        except Exception as error:
            return Receipt(unit.digest, "raised", f"{type(error).__name__}: {error}")
        with _storing():
            kept = store.write(unit, solutions, solver_options)
            journal.stored(unit.digest, effort.cpu_s, effort.wall_s, kept, effort.solves, effort.known)
    except ValueError as error:  # the solver's answer does not fit the scenario
        return Receipt(unit.digest, "raised", f"{type(error).__name__}: {error}")
    except WriteError as error:
        return Receipt(unit.digest, "refused", error.args[-1])
    except (Refused, OSError) as error:
        return Receipt(unit.digest, "refused", str(error))
    return Receipt(unit.digest, "solved" if kept else "already", solves=effort.solves, known=effort.known)


class _Effort:
    """What a unit has taken so far, which the journal is told every few seconds."""

    def __init__(self, unit: str, journal: Journal) -> None:
        self._unit, self._journal = unit, journal
        self._wall, self._cpu = time.perf_counter(), time.process_time()
        self._told = -PROGRESS_EVERY_S  # on the clock of `wall_s`
        self._known_cpu_s = 0.0
        self.solves, self.known = 0, 0

    @property
    def cpu_s(self) -> float:
        """With that of solves which were known."""
        return time.process_time() - self._cpu + self._known_cpu_s

    @property
    def wall_s(self) -> float:
        return time.perf_counter() - self._wall

    def add(self, attempt: Attempt, known: bool) -> None:
        """One solve more."""
        self.solves += 1
        if known:
            self.known += 1
            self._known_cpu_s += attempt.cpu_s
        if self.wall_s - self._told >= PROGRESS_EVERY_S:
            self._told = self.wall_s
            with suppress(OSError):  # a full disk is told about when the part is stored
                self._journal.progress(self._unit, self.cpu_s, self.wall_s, self.solves, self.known)


@contextmanager
def _storing() -> Iterator[None]:
    """Let SIGTERM, which otherwise ends us in the middle of a solve, wait until a part is whole."""
    asked: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, frame: asked.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        if asked:
            os.kill(os.getpid(), signal.SIGTERM)


def _load(unit: Unit, solve: str) -> tuple[SolveTasks, Mapping[str, Any]]:
    planned, ours = json.loads(unit.solver), solver_version()
    if planned != ours:
        raise Refused(
            f"the run was planned with solver code {planned}, this process has {ours}; the code or CasADi changed "
            "under a run, or differs between machines: start the run again with one version everywhere"
        )
    name, _, function = solve.partition(":")
    try:
        return getattr(importlib.import_module(name), function), {"ipopt": IPOPT, "ipopt_warm": IPOPT_WARM}
    except (ImportError, AttributeError) as error:
        raise Refused(f"the solver cannot be loaded ({error}); install gaitflow[solve]") from error


if __name__ == "__main__":
    main()
