"""One local cluster for all tests, faulty solvers on the workers' path, and a scenario of six small units."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import pytest
from distributed import Client

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.execute.local import local_client
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_units


@pytest.fixture(scope="session")
def scenario(checkout: Path) -> Scenario:
    """Quickstart with 2 speeds, 2 durations and 2 held-out tasks, one task a unit."""
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["tasks"] = {
        "axes": {
            "speed": {"start": 0.1, "stop": 1.1, "count": 2},
            "cycle_duration": {"start": 0.4, "stop": 0.8, "count": 2},
        },
        "held_out": 2,
    }
    data["strategy"]["tasks_per_unit"] = 1
    return Scenario.from_data(data, "test")


@pytest.fixture(scope="session")
def units(scenario: Scenario) -> tuple[Unit, ...]:
    return plan_units(scenario)


@pytest.fixture
def store(tmp_path: Path) -> UnitStore:
    return UnitStore(tmp_path / "runs" / "test")


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
