"""The torque of swinging legs' hips on the base: against numbers made by hand, and the check's own numpy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.config.scenario import Objective, Scenario, load_scenario
from gaitflow.core import check
from gaitflow.core.joints import Joints
from gaitflow.core.swing_reaction import swing_reaction
from gaitflow.core.task import AXES, Task
from gaitflow.core.trajectory import Array
from gaitflow.problem import transcribe
from gaitflow.problem.swing_reaction import SwingReaction
from gaitflow.problem.task import TaskParameters
from gaitflow.search import starts

TASK = Task.of({"speed": 0.8, "cycle_duration": 0.4})
SQUARES = 120 / 7  # the integral of the squared second derivative of the smoothest way from 0 to 1


@pytest.fixture(scope="module")
def energy(checkout: Path) -> Scenario:
    """Go1, J4, three knots a phase."""
    scenario = load_scenario(checkout / "configs/scenarios/go1-energy.yaml")
    coarse = scenario.transcription.model_copy(update={"knots_per_phase": 3})
    return scenario.model_copy(update={"transcription": coarse})


def hips(scenario: Scenario) -> Array:
    """Torques [legs, 2] N m of the hips for feet that accelerate by a cycle's way in a second squared."""
    joints = Joints.of(scenario.as_data())
    assert joints is not None
    way = [TASK["speed"] * TASK.cycle_duration, 0.0, 0.0]
    found = [
        limb.inertia @ np.linalg.solve(limb.jacobian(foot), way)
        for limb, foot in zip(joints.limbs, joints.default_feet, strict=True)
    ]
    return np.array(found)[:, :2]


def reaction(scenario: Scenario, pattern: str, durations: list[float], at: Task = TASK) -> float:
    values = ca.SX.sym("task", len(AXES))
    task = TaskParameters(dict(zip(AXES, ca.vertsplit(values), strict=True)))
    contacts = [ca.SX(ca.DM([float(digit) for digit in row])) for row in pattern.split("/")]
    cost = SwingReaction(scenario.robot).integral(task, ca.SX(ca.DM(durations)), contacts)
    return float(ca.Function("cost", [values], [cost])(at.parameters))


def test_legs_that_swing_one_after_the_other_add_their_squares(energy: Scenario) -> None:
    durations = [0.08, 0.12, 0.09, 0.11]
    expected = SQUARES * (hips(energy) ** 2).sum(axis=1) @ np.power(durations, -3.0)
    assert reaction(energy, "0111/1011/1101/1110", durations) == pytest.approx(expected, rel=1e-9)


def test_legs_that_swing_at_once_add_their_torques(energy: Scenario) -> None:
    """A trot, whose swings last two phases; those of RF and LH go over the cycle's end."""
    pairs = hips(energy)[[[0, 3], [1, 2]]].sum(axis=1)
    expected = SQUARES * (pairs**2).sum(axis=1) @ [0.22**-3.0, 0.18**-3.0]
    assert reaction(energy, "1001/0110/0110/1001", [0.1, 0.12, 0.1, 0.08]) == pytest.approx(expected, rel=1e-9)


def test_legs_half_a_swing_apart_cancel_each_other(energy: Scenario) -> None:
    """A four-beat walk: while one leg is slowed down another one is sped up."""
    walk, pace = "0011/1100/0110/1001", "0011/1100/0011/1100"
    assert reaction(energy, walk, [0.1] * 4) < 0.2 * reaction(energy, pace, [0.1] * 4)


def test_where_the_cycle_is_cut_does_not_matter(energy: Scenario) -> None:
    durations, rows = [0.08, 0.12, 0.09, 0.11], ["0011", "1100", "0110", "1011"]
    later = "/".join(row[1:] + row[:1] for row in rows)
    expected = reaction(energy, "/".join(rows), durations)
    assert reaction(energy, later, durations[1:] + durations[:1]) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("axes", [{}, {"yaw_rate": 0.7, "lateral_speed": -0.2}], ids=["straight", "turning"])
@pytest.mark.parametrize("pattern", ["0011/1100/0110/1001", "0110/0111/1110/0110"])
def test_the_check_finds_the_same(energy: Scenario, axes: dict[str, float], pattern: str) -> None:
    task, joints, durations = TASK.replaced(**axes), Joints.of(energy.as_data()), [0.08, 0.12, 0.09, 0.11]
    assert joints is not None
    expected = reaction(energy, pattern, durations, task)
    assert swing_reaction(joints, task, np.array(durations), pattern) == pytest.approx(expected, rel=1e-5)


def test_the_programs_cost_counts_it_as_the_checks_does(energy: Scenario) -> None:
    """On feet that no force acts on: what is left are swings, and what they do to the base."""
    text, durations = "0011/1100/0110/1001", np.array([0.08, 0.12, 0.09, 0.11])
    scenario = energy.model_copy(update={"objective": Objective(joint_heat=0.13, swing_reaction=0.13)})
    problem = transcribe(scenario)
    layout = problem.layout
    motion = layout.unpack(starts.nominal(scenario.robot, layout, TASK), TASK.cycle_duration)
    motion.forces[:] = motion.end_forces[:] = 0.0
    motion = replace(motion, durations=durations, times=layout.times(durations))
    w = layout.pack(motion, TASK.cycle_duration, text)
    found = float(problem.nlp(w, TASK.parameters)[0]) * problem.cost_scale
    data = scenario.as_data()
    assert found == pytest.approx(check.cost(data, motion, TASK, text), rel=1e-5)
    swings = check.cost(data | {"objective": {"joint_heat": 0.13}}, motion, TASK, text)
    assert found - swings == pytest.approx(0.13 * reaction(energy, text, durations.tolist()), rel=1e-3)


def test_it_goes_with_energy_only(energy: Scenario) -> None:
    data = energy.as_data()
    data["objective"] = {"force": 1.0, "swing_reaction": 0.1}
    with pytest.raises(ConfigError, match=r"objective.swing_reaction = 0.1: goes with energy; give joint_heat"):
        Scenario.from_data(data, "no joints")


def test_scenarios_without_it_are_the_same_data_as_before() -> None:
    assert "swing_reaction" not in Objective(joint_heat=0.1).as_data()
    assert Objective(joint_heat=0.1, swing_reaction=0.2).as_data()["swing_reaction"] == 0.2
