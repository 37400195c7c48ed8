"""A Dask cluster of this machine: worker processes on the loopback interface, one thread each.

Other users of the machine can reach that interface. So nobody is let in without the session's key, see `tls`.
"""

from __future__ import annotations

import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from pathlib import Path
from tempfile import TemporaryDirectory

import dask
from distributed import Client, LocalCluster

from gaitflow.execute.drivers import the_local_driver
from gaitflow.execute.open_files import allow_connections
from gaitflow.execute.settings import SETTINGS
from gaitflow.execute.tls import session_security


@contextmanager
def local_client(workers: int = 2) -> Iterator[Client]:
    """A client of `workers` new worker processes, closed with them at the end of the block.

    Workers that die are replaced. They never see a terminal's Ctrl-C: the run stops them.
    """
    allow_connections(workers)
    with (
        TemporaryDirectory(prefix="gaitflow-") as own,  # 0700
        session_security(Path(own)) as security,
        dask.config.set(SETTINGS),  # to the end: the cluster reads them when it loses a worker
    ):
        with _without_ctrl_c():
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                protocol="tls://",
                security=security,
                dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": False},
                memory_limit=0,
                silence_logs=logging.CRITICAL,
            )
        with cluster, Client(cluster) as client:
            yield client


@contextmanager
def local_run_client(run_folder: Path, workers: int) -> Iterator[Client]:
    """`local_client` of the one driver of a run. Raises DriverAlive when another process or job drives it."""
    with the_local_driver(run_folder), local_client(workers) as client:
        yield client


@contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Block SIGINT while the cluster's event loop starts: its thread, and every worker it ever starts, inherit that.

    A Ctrl-C in between is delivered to us at the end of the block.
    """
    resource_tracker.ensure_running()  # started later, it would unblock SIGINT in that thread
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
