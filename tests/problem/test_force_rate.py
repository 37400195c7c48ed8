"""The rate of contact forces: the problem's against the check's, and against a motion whose forces are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from terms import with_axes

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Objective, Scenario, load_scenario
from gaitflow.core.continuous import cost
from gaitflow.core.force_rate import EDGE, force_rate
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search import starts

RANGE = {"start": -1.0, "stop": 1.0, "count": 2}
TASK = Task.of({"speed": 0.6, "cycle_duration": 0.6, "friction": 0.8})


@pytest.fixture(scope="module")
def smooth(checkout: Path) -> Scenario:
    """ANYmal, forces as even as can be."""
    scenario = load_scenario(checkout / "configs/scenarios/anymal-exact-vibration.yaml")
    return scenario.model_copy(update={"objective": Objective(force_rate=1e-3)})


@pytest.mark.parametrize("axes", [{}, {"yaw_rate": 0.7}], ids=["straight", "turning"])
def test_the_problem_and_the_check_agree(smooth: Scenario, axes: dict[str, float]) -> None:
    scenario, task = with_axes(smooth, **dict.fromkeys(axes, RANGE)), TASK.replaced(**axes)
    problem = transcribe(scenario)
    w = starts.random(scenario.robot, problem.layout, task, np.random.default_rng(0))
    trajectory = problem.layout.unpack(w, task.cycle_duration)
    found = float(problem.nlp(w, task.parameters)[0]) * problem.cost_scale
    assert found == pytest.approx(cost(scenario.as_data(), trajectory, task), rel=1e-9)


def test_what_a_ramp_and_its_jumps_take(smooth: Scenario) -> None:
    """One foot's force rises from 0 to 100 N over the first phase and is 0 in all others."""
    problem = transcribe(smooth)
    layout = problem.layout
    w = starts.nominal(smooth.robot, layout, TASK)
    trajectory = layout.unpack(w, 0.6)
    trajectory.forces[:], trajectory.end_forces[:] = 0.0, 0.0
    n, edges = layout.knots_per_phase, np.concatenate([[0.0], np.cumsum(layout.shares)])
    trajectory.forces[:n, 0, 2], trajectory.end_forces[:n, 0, 2] = 100 * edges[:-1], 100 * edges[1:]
    h = np.diff(trajectory.times)
    expected = 100**2 / trajectory.durations[0] + 100**2 / EDGE
    assert force_rate(trajectory, h, TASK) == pytest.approx(expected, rel=1e-9)
    trajectory.forces[:], trajectory.end_forces[:] = 70.0, 70.0
    assert force_rate(trajectory, h, TASK) == 0.0


def test_held_forces_have_none(checkout: Path) -> None:
    data = load_scenario(checkout / "configs/scenarios/anymal-flat-vibration.yaml").as_data()
    data["objective"]["force_rate"] = 1.0
    with pytest.raises(
        ConfigError, match=r"objective.force_rate = 1: held forces have no rate; it needs transcription"
    ):
        Scenario.from_data(data, "held")


def test_scenarios_without_it_are_the_same_data_as_before(smooth: Scenario) -> None:
    assert "force_rate" not in Objective(force=1.0).as_data()
    assert smooth.as_data()["objective"]["force_rate"] == 1e-3
