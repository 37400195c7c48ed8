"""Dask's settings: it ignores a name that it does not know, so they are held against its own."""

from __future__ import annotations

import subprocess
import sys

import dask
import distributed  # noqa: F401, which makes its settings known
import pytest

from gaitflow.execute.settings import CLUSTER_SETTINGS, PROCESS, exports

ABSENT = object()


@pytest.mark.parametrize("name", CLUSTER_SETTINGS)
def test_dask_knows_the_setting(name: str) -> None:
    assert dask.config.get(name, ABSENT) is not ABSENT


def test_a_worker_reads_them_from_its_environment() -> None:
    program = f"import dask, distributed; print([dask.config.get(name) for name in {list(PROCESS)}])"
    script = f'{exports()}\nexec {sys.executable} -c "{program}"'
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str(list(PROCESS.values()))
