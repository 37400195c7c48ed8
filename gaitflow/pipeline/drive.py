"""Solving a plan's units on this machine or on a cluster, with its progress shown."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitflow.config.cluster import Profile
    from gaitflow.execute.count import RunState
    from gaitflow.store.parts import UnitStore
    from gaitflow.store.units import Unit


def drive(units: Sequence[Unit], store: UnitStore, title: str, workers: int, profile: Profile | None) -> RunState:
    """Solve every unit that the store lacks: on `workers` processes, or with a profile on the jobs of a cluster.

    `title` heads the progress. Raises DriverAlive when another process or job solves the run, RunFailed, RunStopped,
    SchedulerError, WriteError.
    """
    from gaitflow.execute.local import local_run_client
    from gaitflow.execute.progress import progress
    from gaitflow.execute.run import run_units
    from gaitflow.execute.solver import longest_unit_s

    with progress(title) as on_event:
        latest: list[RunState] = []

        def remember(state: RunState) -> None:
            latest[:] = [state]
            on_event(state)

        def tell(note: str) -> None:
            on_event(replace(latest[0], notes=(note,)))

        def open_client() -> AbstractContextManager[Any]:
            if profile is None:
                return local_run_client(store.folder, workers)
            from gaitflow.execute.schedulers.cluster_client import cluster_client

            return cluster_client(profile, store.folder, longest_unit_s(units), tell)

        return run_units(units, store, open_client, remember)
