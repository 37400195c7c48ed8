"""One Slurm for all tests of this folder; without Slurm's programs they are skipped, and say so."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "execute"))
sys.path.insert(0, str(Path(__file__).parent))

from cluster import Cluster, missing_programs
from disturbed import Row, fault_document


@pytest.fixture(scope="session")
def slurm_installed() -> None:
    if missing := missing_programs():
        pytest.skip(f"no Slurm here ({', '.join(missing)} not found): apt-get install slurm-wlm munge")


@pytest.fixture(scope="session")
def slurm(slurm_installed: None) -> Iterator[Cluster]:
    """A running Slurm, in the environment of every process started from here; it ends with this process."""
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


@pytest.fixture(scope="session", autouse=True)
def fakes_path() -> Iterator[None]:
    """Lets every process started from here import `fakes`."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent.parent / "execute"), prepend=os.pathsep)
        yield


@pytest.fixture(scope="session")
def rows() -> Iterator[list[Row]]:
    """What the faults of this session did; written down at its end when a path for it is given."""
    rows: list[Row] = []
    yield rows
    if rows and (path := os.environ.get("GAITFLOW_SLURM_FAULTS")):
        Path(path).write_text(json.dumps(fault_document(rows), indent=1) + "\n")


@pytest.fixture
def record_row(rows: list[Row]) -> Callable[[Row], None]:
    return rows.append
