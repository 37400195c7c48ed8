"""How many CPU hours a map takes, before it is submitted: a few of its units are solved here and stored."""

from __future__ import annotations

from collections.abc import Sequence

from gaitflow.config.scenario import Scenario
from gaitflow.execute.local import local_run_client
from gaitflow.execute.progress import progress
from gaitflow.execute.run import run_units
from gaitflow.execute.status import RunStatus, run_status
from gaitflow.pipeline.workspace import Workspace
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units


def estimate(workspace: Workspace, scenario: Scenario, probes: int, workers: int) -> RunStatus:
    """Solve `probes` units, spread over the scenario's plan, unless they are stored; the run's status then.

    Its `cpu_hours_left` is the mean of what was solved, times what is left. Raises RunFailed, RunStopped, DriverAlive.
    """
    store = UnitStore(workspace.run(scenario).folder)
    with progress(scenario.name) as on_event:
        run_units(
            spread(plan_units(scenario), probes), store, lambda: local_run_client(store.folder, workers), on_event
        )
    return run_status(scenario, store)


def spread(units: Sequence[Unit], probes: int) -> tuple[Unit, ...]:
    """The middle ones of `probes` equal parts of a plan; all of a shorter plan."""
    probes = min(probes, len(units))
    return tuple(units[(2 * i + 1) * len(units) // (2 * probes)] for i in range(probes))
