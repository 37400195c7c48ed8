"""The tests' own Slurm: it runs jobs, and nothing of it is left when it ends, however it ends."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from cluster import NODES, Cluster

pytestmark = [pytest.mark.slurm, pytest.mark.usefixtures("slurm_installed")]


def wait_until(condition: Callable[[], object], seconds: float = 30.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it took too long"
        time.sleep(0.1)


def test_a_job_runs_on_the_node_it_asks_for(cluster: Cluster, tmp_path: Path) -> None:
    script = tmp_path / "job.sh"
    script.write_text('#!/bin/bash\necho "$SLURMD_NODENAME $SLURM_JOB_ID"\n')
    job = cluster.call("sbatch", "--parsable", "-w", "n2", "-o", f"{tmp_path}/out", str(script)).strip()
    wait_until(lambda: (tmp_path / "out").exists() and (tmp_path / "out").read_text() == f"n2 {job}\n")
    wait_until(lambda: cluster.call("squeue", "-h") == "")
    assert cluster.idle_nodes() == len(NODES)


def test_it_ends_with_the_process_it_was_started_for(tmp_path: Path) -> None:
    """Also when that is killed with a job running, and the job's children hide in a session of their own."""
    folder = tmp_path / "s"
    program = str(Path(__file__).with_name("cluster.py"))
    with subprocess.Popen(["sleep", "600"]) as owner:
        subprocess.run([sys.executable, program, "start", folder, "--until", str(owner.pid)], check=True, timeout=60)
        cluster = Cluster(folder)
        cluster.call("sbatch", "-o", "/dev/null", "--wrap", "setsid sleep 600 & sleep 600")
        wait_until(lambda: len(cluster.job_processes()) >= 3)
        everyone = [*cluster.daemons(), *cluster.job_processes()]
        assert len(everyone) >= 9  # keeper, munged, slurmctld, 3 slurmd, slurmstepd, and the job
        owner.kill()
    # The keeper removes the folder and then ends itself.
    wait_until(lambda: not folder.exists() and not cluster.daemons() and not cluster.job_processes())


def test_by_hand(tmp_path: Path) -> None:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        program = str(Path(__file__).with_name("cluster.py"))
        return subprocess.run([sys.executable, program, *arguments], capture_output=True, text=True, timeout=60)

    folder = str(tmp_path / "s")
    assert "start|stop|env" in run("--help").stdout
    refused = run("stop", str(tmp_path))
    assert refused.returncode == 1 and "no cluster was started there" in refused.stderr and tmp_path.exists()
    assert run("start", folder).returncode == 0
    again = run("start", folder)
    assert again.returncode == 1 and "exists; choose a new folder" in again.stderr
    shown = subprocess.run(
        ["bash", "-c", f'{run("env", folder).stdout} sinfo -h -o "%D %t" -p work'],
        env={"PATH": os.environ["PATH"]},
        capture_output=True,
        text=True,
    )
    assert shown.stdout == "3 idle\n"
    assert run("stop", folder).returncode == 0 and not Path(folder).exists()
