"""Workers that sleep instead of solving, a hundred in one process: `python -m benchmarks.infrastructure.stand_ins`.

Each is a Dask worker of its own, with its own encrypted connections, task thread and journal. What they stand in for
is the solver process and its CPU time, so that a few hundred fit on one machine.
"""

from __future__ import annotations

import argparse
import asyncio
import logging
import secrets
import time
from collections.abc import Sequence
from pathlib import Path

import dask
from distributed import Security, Worker, WorkerPlugin
from distributed.core import ErrorMessage, OKMessage

from benchmarks.infrastructure.idle import idle_solutions
from gaitflow.execute.line_process import die_with
from gaitflow.execute.receipt import Receipt
from gaitflow.execute.settings import PROCESS
from gaitflow.execute.solver import Solver
from gaitflow.execute.worker import SolverPlugin
from gaitflow.store.journal import Journal
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit
from gaitflow.tables.solver_code import solver_version

SOLVES = 100  # that a unit is said to have taken


class Sleeper(Solver):
    """Takes `mean_s` a unit, between half and one and a half of it as the unit's digest has it."""

    def __init__(self, mean_s: float, stores: bool) -> None:
        super().__init__()
        self._mean_s, self._stores = mean_s, stores
        self._called = f"sleeper-{secrets.token_hex(8)}"

    def run(self, unit: Unit, store: UnitStore, limit_s: float | None = None) -> Receipt:
        """Sleep, and store rows that say "infeasible" where parts are to be stored."""
        journal, begin = Journal(store.folder / "journal", self._called), time.perf_counter()
        journal.started(unit.digest)
        time.sleep(self._mean_s * (0.5 + int(unit.digest[:8], 16) / 2**32))
        kept = self._stores and store.write(unit, idle_solutions(unit.scenario, unit.tasks), {})
        journal.stored(unit.digest, 0.0, time.perf_counter() - begin, kept, SOLVES)
        return Receipt(unit.digest, "solved", solves=SOLVES)


class SleeperPlugin(SolverPlugin):
    """In the place of the plugin that gives a worker its solver."""

    def __init__(self, mean_s: float, stores: bool) -> None:
        super().__init__("")
        self._mean_s, self._stores = mean_s, stores

    def setup(self, worker: Worker) -> None:
        """Called by Dask."""
        self.solver = Sleeper(self._mean_s, self._stores)


class StandIn(Worker):
    """A worker that takes a sleeper for the solver that the run gives to its workers."""

    sleeper: tuple[float, bool] = (0.0, False)

    async def plugin_add(
        self, plugin: WorkerPlugin | bytes, name: str | None = None, catch_errors: bool = True
    ) -> ErrorMessage | OKMessage:
        """Called by the scheduler."""
        if name == SolverPlugin.name:
            plugin = SleeperPlugin(*self.sleeper)
        return await super().plugin_add(plugin, name, catch_errors)


async def stand_in(address: str, security: Security, workers: int) -> None:
    """Join the scheduler with so many workers, and end with it."""
    names = [f"stand-in-{secrets.token_hex(8)}" for _ in range(workers)]
    joined = [
        StandIn(address, nthreads=1, name=name, security=security, memory_limit=0, dashboard=False) for name in names
    ]
    for worker in joined:
        await worker
    await asyncio.gather(*(worker.finished() for worker in joined))


def main(arguments: Sequence[str] | None = None) -> None:
    """Serve until the scheduler goes away, or the process that started this one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parent", type=int, required=True)
    parser.add_argument("--scheduler", required=True)
    parser.add_argument("--certificate", type=Path, required=True)
    parser.add_argument("--key", type=Path, required=True)
    parser.add_argument("--workers", type=int, required=True)
    parser.add_argument("--unit-s", type=float, required=True)
    parser.add_argument("--store", action="store_true")
    options = parser.parse_args(arguments)
    die_with(options.parent)
    solver_version()  # once for all, before there are threads: what parses code in several at a time may fail
    certificate, key = str(options.certificate), str(options.key)
    security = Security(
        require_encryption=True, tls_ca_file=certificate, tls_worker_cert=certificate, tls_worker_key=key
    )
    StandIn.sleeper = options.unit_s, options.store
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # a hundred say goodbye at once
    with dask.config.set(PROCESS):
        asyncio.run(stand_in(options.scheduler, security, options.workers))


if __name__ == "__main__":
    main()
