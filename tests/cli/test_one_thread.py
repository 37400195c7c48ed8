"""A stage solves on one thread of algebra, whatever the environment says; Snakemake asks for a thread a core."""

from __future__ import annotations

import json
import os
import subprocess
import sys

ASK = """
import json
import gaitflow.cli
import casadi, scipy.linalg
from threadpoolctl import threadpool_info
print(json.dumps([each["num_threads"] for each in threadpool_info()]))
"""


def threads_of(imported: str) -> list[int]:
    environment = os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    command = [sys.executable, "-c", imported]
    found: list[int] = json.loads(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
    return found


def test_algebra_has_one_thread_where_the_environment_asks_for_two() -> None:
    assert set(threads_of(ASK)) == {1}


def test_without_the_command_line_the_environment_counts() -> None:
    assert set(threads_of(ASK.replace("import gaitflow.cli\n", ""))) == {2}
