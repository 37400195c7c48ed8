"""Limits of open files are those of a process, so each case has a process of its own."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import resource, sys
from gaitflow.execute.open_files import allow_connections
resource.setrlimit(resource.RLIMIT_NOFILE, (int(sys.argv[1]), int(sys.argv[2])))
print(allow_connections(int(sys.argv[3])))
print(resource.getrlimit(resource.RLIMIT_NOFILE)[0])
"""


@pytest.mark.parametrize(
    ("soft", "hard", "workers", "limit"),
    [(1024, 4096, 900, 3856), (1024, 4096, 100, 1024), (1024, 4096, 960, 4096)],
    ids=["raised", "enough", "just enough"],
)
def test_as_many_files_as_the_workers_take(soft: int, hard: int, workers: int, limit: int) -> None:
    assert told(soft, hard, workers) == ["", str(limit)]


def test_a_hard_limit_that_is_too_low_is_told() -> None:
    note, limit = told(256, 1024, 400)
    assert limit == "1024", "as far as it goes"
    assert note.startswith("the driver may open 1024 files here, 400 workers take about 1856: with more than 192 jobs")


def told(soft: int, hard: int, workers: int) -> list[str]:
    command = [sys.executable, "-c", PROGRAM, *map(str, (soft, hard, workers))]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
