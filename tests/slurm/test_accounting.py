"""Slurm's accounts of a run, beside the CPU time that its units say of themselves."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import accounting
import pytest
import yaml
from cluster import Cluster, missing_programs
from command import gaitflow

pytestmark = [pytest.mark.slurm, pytest.mark.slow, pytest.mark.timeout(300)]

ENDS_WITHIN_S = 30.0  # a job's own processes, after the run


@pytest.fixture
def cluster(slurm_installed: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    """A Slurm that keeps accounts."""
    if missing := missing_programs(accounting.PROGRAMS):
        pytest.skip(f"no accounts here ({', '.join(missing)} not found): apt-get install slurmdbd mariadb-server")
    folder = Path(tempfile.mkdtemp(prefix="gaitflow-slurm-"), "slurm")  # a socket's path must be short
    cluster = Cluster(folder)
    cluster.start(until=os.getpid(), with_accounting=True)
    for name, value in cluster.environment().items():
        monkeypatch.setenv(name, value)
    yield cluster
    cluster.stop()
    folder.parent.rmdir()


def cpu_seconds(cluster: Cluster) -> float:
    """What Slurm counted for all jobs, once they have ended and two readings agree [s]: it counts a moment later."""
    deadline, before = time.monotonic() + ENDS_WITHIN_S, 0.0
    while True:
        told = cluster.call("sacct", "--allusers", "--noheader", "--parsable2", "-o", "JobID,State,TotalCPU")
        steps = [line.split("|") for line in told.splitlines() if ".batch|" in line]
        counted = sum(_seconds(cpu) for _, _, cpu in steps)
        if all(state != "RUNNING" for _, state, _ in steps) and not cluster.call("squeue", "--noheader"):
            if 0 < counted == before:
                return counted
            before = counted
        assert time.monotonic() < deadline, told
        time.sleep(1.0)


def _seconds(text: str) -> float:
    """Of sacct's [DD-[hh:]]mm:ss[.mmm] or hh:mm:ss."""
    days, _, clock = text.rpartition("-")
    seconds = 0.0
    for part in clock.split(":"):
        seconds = 60 * seconds + float(part)
    return 86400 * int(days or 0) + seconds


def test_units_tell_most_of_the_time_that_slurm_counts(cluster: Cluster, checkout: Path, tmp_path: Path) -> None:
    shutil.copytree(checkout / "configs", tmp_path / "configs")
    file = tmp_path / "configs" / "scenarios" / "quickstart.yaml"
    data = yaml.safe_load(file.read_text())
    data["tasks"]["axes"] |= {"speed": {"start": 0.4, "stop": 1.2, "count": 3}, "cycle_duration": 0.6}
    file.write_text(yaml.safe_dump(data))
    profile = checkout / "slurm" / "profiles" / "test-cluster.yaml"
    gaitflow(tmp_path, "solve", "quickstart", "--profile", profile)
    told = 3600 * json.loads(gaitflow(tmp_path, "status", "quickstart", "--json"))["cpu_hours_spent"]
    counted = cpu_seconds(cluster)
    # The rest: imports and preparation, once a worker, and writing.
    assert 0.3 * counted < told < counted, (told, counted)
