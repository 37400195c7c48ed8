"""The process that solves: `python -m gaitflow.execute.solver_process`, driven over its standard streams.

In: a line of JSON {"unit": ..., "store": folder, "solver": its name in the journal} a unit. Out: a receipt a line. It
solves *and* stores, so that a part is durable before anyone hears of it. It is a process of its own because a MINLP
solver may throw through C++, hang or die; it ends at the end of its input, and at once when its parent dies.
"""

from __future__ import annotations

import argparse
import ctypes
import faulthandler
import importlib
import io
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import Task
from gaitflow.execute.receipt import Receipt
from gaitflow.files import WriteError
from gaitflow.search.solution import Solution
from gaitflow.store.journal import Journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, solver_version

SolveTasks = Callable[[Scenario, Sequence[Task], "tuple[int, ...] | None"], list[Solution]]
SOLVE = "gaitflow.search:solve_tasks"
PR_SET_PDEATHSIG = 1
PARENT_CHECK_S = 1.0


class Refused(Exception):
    """No unit can be solved here, whatever the unit: the run has to stop and say why."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve units from standard input until it ends."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parent", type=int, required=True, help="process to live and die with")
    parser.add_argument("--solve", default=SOLVE, help="module:function; tests put a faulty solver here")
    options = parser.parse_args(arguments)
    die_with(options.parent)
    faulthandler.enable()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the run's to handle, which then ends us
    solver_version()  # names the code as it is loaded now, not as it may be edited later
    receipts = _protect_stdout()
    for line in sys.stdin:
        request = json.loads(line)
        store = UnitStore(Path(request["store"]))
        journal = Journal(store.folder / "journal", request["solver"])
        receipts.write(serve(Unit.from_data(request["unit"]), store, journal, options.solve).to_line())
        receipts.flush()


def serve(unit: Unit, store: UnitStore, journal: Journal, solve: str) -> Receipt:
    """Solve and store one unit unless it is stored; never raises for what the solver or the disk does."""
    if store.has(unit):
        return Receipt(unit.digest, "already")
    try:
        function, solver_options = _load(unit, solve)
        journal.started(unit.digest)
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            solutions = function(unit.scenario, unit.tasks, unit.seeds)
        except Exception as error:
            return Receipt(unit.digest, "raised", f"{type(error).__name__}: {error}")
        with _storing():
            kept = store.write(unit, solutions, solver_options)
            journal.stored(unit.digest, time.process_time() - cpu, time.perf_counter() - wall, kept)
    except ValueError as error:  # the solver's answer does not fit the scenario
        return Receipt(unit.digest, "raised", f"{type(error).__name__}: {error}")
    except WriteError as error:
        return Receipt(unit.digest, "refused", error.args[-1])
    except (Refused, OSError) as error:
        return Receipt(unit.digest, "refused", str(error))
    return Receipt(unit.digest, "solved" if kept else "already")


def die_with(parent: int) -> None:
    """End this process as soon as `parent` ends, even inside a solver that does not return to Python."""
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_CHECK_S)
        os._exit(1)

    if os.getppid() != parent:  # it died before we asked to be told
        os._exit(1)
    threading.Thread(target=watch, daemon=True, name="parent watch").start()


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


def _protect_stdout() -> TextIO:
    """The stream of receipts; whatever else prints, from Python or C, goes to standard error if there is room."""
    receipts = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    sys.stdout = sys.stderr = io.TextIOWrapper(_Chatter(2, "w", closefd=False), errors="replace", write_through=True)
    return receipts


class _Chatter(io.FileIO):
    """What a solver says: losing it, on a scratch disk that is full, must not lose the solution."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError:
            return memoryview(data).nbytes


def _load(unit: Unit, solve: str) -> tuple[SolveTasks, Mapping[str, Any]]:
    planned, ours = json.loads(unit.solver), solver_version()
    if planned != ours:
        raise Refused(
            f"the run was planned with solver code {planned}, this process has {ours}; the code or CasADi changed "
            "under a run, or differs between machines: start the run again with one version everywhere"
        )
    name, _, function = solve.partition(":")
    try:
        from gaitflow.solvers.options import IPOPT, IPOPT_WARM  # not before: it loads CasADi

        return getattr(importlib.import_module(name), function), {"ipopt": IPOPT, "ipopt_warm": IPOPT_WARM}
    except (ImportError, AttributeError) as error:
        raise Refused(f"the solver cannot be loaded ({error}); install gaitflow[solve]") from error


if __name__ == "__main__":
    main()
