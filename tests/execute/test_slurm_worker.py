"""What runs inside a worker's job, tried without Slurm."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import dask
from distributed import Client, LocalCluster, Status

from gaitflow.execute.drain import DrainingWorker
from gaitflow.execute.local import SETTINGS


def test_a_worker_loads_no_learning_and_no_plots() -> None:
    code = (
        "import sys, distributed.cli.dask_worker, gaitflow.execute.drain, gaitflow.execute.worker, "
        "gaitflow.execute.solver_process, gaitflow.solvers.ipopt; "
        "print({'torch', 'skorch', 'sklearn', 'onnx', 'matplotlib', 'snakemake'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def slow(folder: str, number: int) -> int:
    Path(folder, f"began-{number}").touch()
    time.sleep(1.5)
    Path(folder, f"ended-{number}").touch()
    return number


def test_a_worker_at_its_lifetime_ends_its_unit_and_takes_no_other(tmp_path: Path) -> None:
    with (
        dask.config.set(SETTINGS),
        LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            worker_class=DrainingWorker,
            protocol="tcp://",
            memory_limit=0,
            host="127.0.0.1",
            dashboard_address=None,
        ) as cluster,
        Client(cluster) as client,
    ):
        waiting = [client.submit(slow, str(tmp_path), number, pure=False) for number in range(3)]
        while not list(tmp_path.glob("began-*")):
            time.sleep(0.02)
        (worker,) = cluster.workers.values()
        client.sync(worker.close_gracefully, reason="worker-lifetime-reached")
        assert len(list(tmp_path.glob("began-*"))) == len(list(tmp_path.glob("ended-*"))) == 1
        assert worker.status == Status.closed
        assert not any(future.status == "error" for future in waiting), "the others are left for other workers"
