from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from rigid_motion import random_motion, simulated
from scipy.spatial.transform import Rotation
from terms import constants, layout_of, node_of

from gaitflow.config.scenario import Objective, Scenario
from gaitflow.core import twist
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.problem.dynamics import body_of
from gaitflow.problem.objectives import StepCost

VIBRATION = Objective(tangential_velocity=2.0, normal_velocity=3.0, tilt=5.0, tilt_rate=7.0)
STRAIGHT = Task.of({"speed": 1.0, "cycle_duration": 0.6})
TURNING = Task.of({"speed": 1.0, "lateral_speed": 0.2, "yaw_rate": 0.9, "acceleration": 0.5, "cycle_duration": 0.6})


def step_cost(
    scenario: Scenario, task: Task, ends: tuple[Array, Array], forces: tuple[Array, Array], t0: float, h: float
) -> StepCost:
    parameters = constants(task)
    body = body_of(scenario.robot, parameters)
    first, last = (node_of(body, x, f) for x, f in zip(ends, forces, strict=True))
    return StepCost(scenario.robot, parameters, (first, last), (ca.SX(t0), ca.SX(t0 + h)), ca.SX(h))


def sampled(scenario: Scenario, objective: Objective, x: Array, forces: Array, task: Task, t0: float = 0.0) -> float:
    """The integrand: the paper's sum over one step of a second."""
    return float(ca.DM(step_cost(scenario, task, (x, x), (forces, forces), t0, 1.0).sampled(objective)))


def test_effort_is_the_sum_of_squared_forces(either: Scenario) -> None:
    """Eq. (8): 3-4-0 makes 25."""
    layout = layout_of(either)
    forces = np.zeros((layout.legs, layout.dimension))
    forces[0, 0], forces[-1, -1] = 3.0, 4.0
    assert sampled(either, Objective(force=2.0), np.ones(layout.nx), forces, STRAIGHT) == pytest.approx(2 * 25)


def test_vibration_in_the_plane(planar: Scenario) -> None:
    """Eq. (9), with pitch measured from the slope."""
    x = np.concatenate([[9.0, 9.0, 0.1, 1.5, -0.2, 0.4], np.full(4, 9.0)])
    expected = 2 * 0.5**2 + 3 * 0.2**2 + 5 * 0.1**2 + 7 * 0.4**2
    assert sampled(planar, VIBRATION, x, np.full((2, 2), 9.0), STRAIGHT) == pytest.approx(expected)


def test_vibration_in_space(anymal: Scenario) -> None:
    """Eq. (10): lateral speed counts as tangential; the rates are those of the angles, not the body rates."""
    x = np.zeros(24)
    angles, rates = np.array([0.3, -0.4, 0.5]), np.array([0.6, -0.7, 0.8])
    e = 1e-6
    before, after = (Rotation.from_euler("ZYX", angles + side * e * rates) for side in (-1, 1))
    x[3:6], x[6:9], x[9:12] = angles, (1.5, 0.3, -0.2), (before.inv() * after).as_rotvec() / (2 * e)
    expected = 2 * (0.5**2 + 0.3**2) + 3 * 0.2**2 + 5 * np.sum(angles**2) + 7 * np.sum(rates**2)
    assert sampled(anymal, VIBRATION, x, np.zeros((4, 3)), STRAIGHT) == pytest.approx(expected)


def test_lateral_feet_are_measured_from_their_default(anymal: Scenario) -> None:
    x = np.full(24, 9.0)
    x[13::3] = [0.199 + 0.1, -0.199, 0.199, -0.199 - 0.2]
    lateral = Objective(lateral_foot=3.0)
    assert sampled(anymal, lateral, x, np.zeros((4, 3)), STRAIGHT) == pytest.approx(3 * (0.1**2 + 0.2**2))


@pytest.mark.parametrize("time", [0.0, 0.25, 0.6])
def test_everything_is_seen_from_the_frame_that_follows_the_twist(anymal: Scenario, time: float) -> None:
    """A state a bit off the command, moved along with it: the same cost at any time, but for the acceleration."""
    every = VIBRATION.model_copy(update={"lateral_foot": 11.0})
    turn, origin = 0.9 * time, twist.displacements(TURNING, np.array(time))
    to_world = Rotation.from_euler("z", turn).as_matrix()
    forward = 1.0 + 0.5 * (time - 0.3)
    off = {"velocity": np.array([0.1, -0.2, 0.3]), "angles": np.array([0.05, 0.1, -0.1])}
    default = np.array([leg.default_foot for leg in anymal.robot.legs])
    feet = default + np.array([0.5, 0.03, 0.0])
    x = np.zeros(24)
    x[3:6] = off["angles"] + [turn, 0, 0]
    x[6:9] = to_world @ (np.array([forward, 0.2, 0.0]) + off["velocity"])
    x[12:] = (np.append(origin, 0.0) + feet @ to_world.T).ravel()
    e = 1e-6
    before, after = (Rotation.from_euler("ZYX", x[3:6] + side * e * np.array([0.9, 0, 0])) for side in (-1, 1))
    x[9:12] = (before.inv() * after).as_rotvec() / (2 * e)
    expected = 2 * (0.1**2 + 0.2**2) + 3 * 0.3**2 + 5 * np.sum(off["angles"] ** 2) + 11 * 4 * 0.03**2
    assert sampled(anymal, every, x, np.zeros((4, 3)), TURNING, time) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("term", "tolerance"), [
    ("force", 1e-12), ("lateral_foot", 1e-12), ("normal_velocity", 1e-9), ("tangential_velocity", 1e-9),
    ("tilt", 1e-3), ("tilt_rate", 1e-3),
])  # fmt: skip
def test_the_integral_along_the_motion(anymal: Scenario, term: str, tolerance: float) -> None:
    """Of a simulated step of 20 ms under linear forces, against 10-point Gauss-Legendre quadrature of the integrand.

    Exact for forces, feet and velocities; of fourth order for angles and their rates.
    """
    layout, h, t0 = layout_of(anymal), 0.02, 0.1
    objective = Objective(**{term: 3.0})
    x, forces, speeds = random_motion(layout, anymal.robot, 0)
    ends = forces + random_motion(layout, anymal.robot, 1)[1] * 0.3
    nodes, weights = np.polynomial.legendre.leggauss(10)
    expected = 0.0
    for node, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        state = simulated(anymal.robot, 0.0, x, forces, ends, speeds, h, node * h)
        there = forces + node * (ends - forces)
        expected += h * weight * sampled(anymal, objective, state, there, STRAIGHT, t0 + node * h)
    last = simulated(anymal.robot, 0.0, x, forces, ends, speeds, h, h)
    found = step_cost(anymal, STRAIGHT, (x, last), (forces, ends), t0, h).integrated(objective)
    assert float(ca.DM(found)) == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize("seed", range(20))
def test_no_step_has_a_negative_cost(anymal: Scenario, seed: int) -> None:
    """However far its two ends are from one motion: each integral is one of squares."""
    layout = layout_of(anymal)
    (x, f, _), (y, g, _) = (random_motion(layout, anymal.robot, 2 * seed + i) for i in (0, 1))
    for term in Objective.model_fields:
        found = step_cost(anymal, TURNING, (x, y), (f, g), 0.1, 0.3).integrated(Objective(**{term: 1.0}))
        assert float(ca.DM(found)) >= 0
