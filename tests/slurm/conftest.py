"""One Slurm for all tests of this folder; without Slurm's programs they are skipped, and say so."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from cluster import Cluster, missing_programs


@pytest.fixture(scope="session")
def slurm() -> Iterator[Cluster]:
    """A running Slurm, in the environment of every process started from here; it ends with this process."""
    if missing := missing_programs():
        pytest.skip(f"no Slurm here ({', '.join(missing)} not found): apt-get install slurm-wlm munge")
    folder = Path(tempfile.mkdtemp(prefix="gaitflow-slurm-"), "slurm")  # a socket's path must be short
    program = Path(__file__).with_name("cluster.py")
    subprocess.run([sys.executable, program, "start", folder, "--until", str(os.getpid())], check=True, timeout=120)
    cluster = Cluster(folder)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in cluster.environment().items():
            patch.setenv(name, value)
        yield cluster
    cluster.stop()
    folder.parent.rmdir()


@pytest.fixture
def cluster(slurm: Cluster) -> Iterator[Cluster]:
    """The Slurm with every part at work and no job, before and after a test."""
    slurm.repair()
    yield slurm
    slurm.repair()
