"""The two bodies that every term is tested on: a planar pair of legs and ANYmal in space."""

from __future__ import annotations

from pathlib import Path

import pytest
from terms import with_axes

from gaitflow.config.scenario import Scenario, Transcription, load_scenario


@pytest.fixture(scope="session")
def planar(checkout: Path) -> Scenario:
    """The paper's settings in the plane, up a slope."""
    return load_scenario(checkout / "tests/data/scenarios/planar-slope20-vibration.yaml")


@pytest.fixture(scope="session")
def anymal(checkout: Path) -> Scenario:
    """The paper's settings in space."""
    return load_scenario(checkout / "tests/data/scenarios/anymal-flat-vibration.yaml")


@pytest.fixture(scope="session")
def small_anymal(anymal: Scenario) -> Scenario:
    """Three knots a phase, up a slope, with a full inertia tensor: every term of the dynamics at work."""
    robot = anymal.robot.model_copy(update={"inertia": ((1.004, 0.1, -0.2), (0.1, 2.078, 0.05), (-0.2, 0.05, 2.082))})
    sloped = with_axes(anymal, slope=15.0)
    return sloped.model_copy(update={"robot": robot, "transcription": Transcription(knots_per_phase=3)})


@pytest.fixture(params=["planar", "small_anymal"])
def either(request: pytest.FixtureRequest) -> Scenario:
    """A scenario in the plane, then one in space."""
    scenario: Scenario = request.getfixturevalue(request.param)
    return scenario
