"""The nominal start in symbols is the search's."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from tiny_map import CONFIGS

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core.layout import Layout
from gaitflow.core.task import AXIS_NAMES, Task
from gaitflow.export.nominal import nominal
from gaitflow.search import starts

# In space and in the plane, with linear and held forces, with contacts as variables.
SCENARIOS = ("anymal-omni", "anymal-energy", "half-cheetah-exact-slopes", "half-cheetah-flat-effort")


def written(scenario: Scenario) -> casadi.Function:
    task = casadi.SX.sym("task", len(AXIS_NAMES))
    feet = np.array([leg.default_foot for leg in scenario.robot.legs])
    return casadi.Function("nominal", [task], [nominal(Layout.of(scenario.as_data()), feet, task)])


def assert_equal(scenario: Scenario, task: Task) -> None:
    expected = starts.nominal(scenario.robot, Layout.of(scenario.as_data()), task)
    found = written(scenario)(task.parameters).full().ravel()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", SCENARIOS)
def test_at_random_tasks(name: str) -> None:
    scenario, random = load_scenario(CONFIGS / "scenarios" / f"{name}.yaml"), np.random.default_rng(0)
    for _ in range(3):
        values = {axis: random.uniform(each.start, each.stop) for axis, each in scenario.tasks.ranges.items()}
        assert_equal(scenario, scenario.tasks.space.task(values))


@pytest.mark.parametrize("yaw_rate", [0.0, 1e-12, -1e-7, 0.8])
def test_straight_ahead_and_hardly_turning(yaw_rate: float) -> None:
    scenario = load_scenario(CONFIGS / "scenarios" / "anymal-omni.yaml")
    task = {"speed": 0.7, "lateral_speed": -0.2, "yaw_rate": yaw_rate, "cycle_duration": 0.6}
    assert_equal(scenario, scenario.tasks.space.task(task))
