"""One local cluster for all tests, faulty solvers on the workers' path, and a scenario of six small units."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import pytest
from distributed import Client
from small_units import quickstart, store, units

from gaitflow.config.scenario import Scenario
from gaitflow.execute.local import local_client

__all__ = ["store", "units"]


@pytest.fixture(scope="session")
def scenario(checkout: Path) -> Scenario:
    """Quickstart with 2 speeds, 2 durations and 2 held-out tasks, one task a unit."""
    return quickstart(checkout, speeds=(0.1, 1.1, 2), cycles=(0.4, 0.8, 2), held_out=2, tasks_per_unit=1)


@pytest.fixture(scope="session", autouse=True)
def fakes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Lets every process started from here import `fakes`; the folder in which they leave their marks."""
    folder = tmp_path_factory.mktemp("fakes")
    with pytest.MonkeyPatch.context() as patch:
        path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
        patch.setenv("PYTHONPATH", path.rstrip(os.pathsep))
        patch.setenv("FAKE_FOLDER", str(folder))
        yield folder


@pytest.fixture(scope="session")
def client(fakes: Path) -> Iterator[Client]:
    with local_client(workers=2) as client:
        yield client


@pytest.fixture
def open_client(client: Client) -> Callable[[], AbstractContextManager[Client]]:
    return lambda: nullcontext(client)
