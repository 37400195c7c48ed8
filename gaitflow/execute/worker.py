"""What runs inside a Dask worker: a plugin that owns the solver, and the one task that uses it."""

from __future__ import annotations

import json
from pathlib import Path

from distributed import Worker, WorkerPlugin, get_worker

from gaitflow.execute.receipt import Receipt
from gaitflow.execute.solver import Solver
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit


class SolverPlugin(WorkerPlugin):
    """Gives every worker, also one that joins later, its own solver process."""

    name = "gaitflow-solver"

    def __init__(self, solve: str) -> None:
        self._solve = solve
        self.solver: Solver | None = None

    def setup(self, worker: Worker) -> None:
        """Called by Dask when the worker starts; the process itself starts with the first unit."""
        self.solver = Solver(self._solve)

    def teardown(self, worker: Worker) -> None:
        """Called by Dask when the worker closes: ends a solve in flight, so that closing takes no time."""
        if self.solver is not None:
            self.solver.close()


def solve_unit(unit: str, folder: str) -> Receipt:
    """The Dask task: a unit's JSON and the store's folder in, a small receipt out. Raises SolverClosed."""
    plugin = get_worker().plugins[SolverPlugin.name]
    assert isinstance(plugin, SolverPlugin) and plugin.solver is not None
    return plugin.solver.run(Unit.from_data(json.loads(unit)), UnitStore(Path(folder)))
