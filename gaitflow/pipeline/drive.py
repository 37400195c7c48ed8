"""Solving a plan's units on this machine or on a cluster, with its progress shown."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitflow.config.cluster import Profile
    from gaitflow.execute.count import RunState
    from gaitflow.execute.display import Tell
    from gaitflow.store.parts import UnitStore
    from gaitflow.store.units import Unit


def drive(units: Sequence[Unit], store: UnitStore, tell: Tell, workers: int, profile: Profile | None) -> RunState:
    """Solve every unit that the store lacks: on `workers` processes, or with a profile on the jobs of a cluster.

    `tell` hears how far it is. Raises DriverAlive when another process or job solves the run, RunFailed, RunStopped,
    SchedulerError, WriteError.
    """
    from gaitflow.execute.local import local_run_client
    from gaitflow.execute.progress import describe, share
    from gaitflow.execute.run import run_units
    from gaitflow.execute.solver import longest_unit_s

    latest: list[RunState] = []

    def on_event(state: RunState) -> None:
        latest[:] = [state]
        tell(describe(state), share(state), state.notes)

    def note(text: str) -> None:
        tell(describe(latest[0]), share(latest[0]), (text,))

    def open_client() -> AbstractContextManager[Any]:
        if profile is None:
            return local_run_client(store.folder, workers)
        from gaitflow.execute.schedulers.cluster_client import cluster_client

        return cluster_client(profile, store.folder, longest_unit_s(units), note)

    return run_units(units, store, open_client, on_event)
