"""ANYmal B of example-robot-data, and plans of its map."""

from __future__ import annotations

from importlib.metadata import files
from pathlib import Path

import pytest

from gaitflow.clients.default_gaits import default_motion
from gaitflow.clients.whole_body import WholeBody, load_whole_body
from gaitflow.motion import Motion
from gaitflow.runtime import GaitMap, Plan

ANYMAL = "share/example-robot-data/robots/anymal_b_simple_description/robots/anymal.urdf"


@pytest.fixture(scope="session")
def anymal() -> Path:
    """The description that the map's robot was imported from."""
    (found,) = (file for file in files("example-robot-data") or () if str(file).endswith(ANYMAL))
    return Path(str(found.locate()))


@pytest.fixture(scope="session")
def plan(checkout: Path) -> Plan:
    return GaitMap.load(checkout / "models" / "anymal-exact-vibration").plan(speed=0.6, cycle_duration=0.6)


@pytest.fixture(scope="session")
def planned(plan: Plan) -> Motion:
    return plan.motion()


@pytest.fixture(scope="session")
def trot(planned: Motion) -> Motion:
    """A hand-made trot at the plan's task."""
    return default_motion(planned.scenario, "trot", planned.task, 0.5)


@pytest.fixture(scope="session")
def body(anymal: Path, plan: Plan) -> WholeBody:
    return load_whole_body(anymal, plan.scenario)
