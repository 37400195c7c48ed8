"""Joints of the check against the foot's place by angles, swings by hand, and the problem's closed form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from terms import numbers

from gaitflow.config.robot import Robot, load_robot
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.core import joints
from gaitflow.core.joints import Joints, Limb
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.problem import energy
from gaitflow.problem.limb import LegPose

CONFIGS = Path(__file__).parents[2] / "configs"
ROBOTS = ("anymal", "go1", "hyq", "solo12")


@pytest.fixture(params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(CONFIGS / "robots" / f"{request.param}.yaml")


@pytest.fixture(scope="module")
def walking() -> Scenario:
    """ANYmal, J4."""
    return load_scenario(CONFIGS / "scenarios" / "anymal-energy.yaml")


def limbs_of(robot: Robot) -> list[Limb]:
    return [Limb.of(limb) for limb in robot.as_data()["limbs"]]


def foot_at(limb: Limb, angles: Array) -> Array:
    """Forward kinematics, a rotation a joint: abduction about x, then flexion and knee about the leg's y."""
    a, flexion, knee = angles
    swung = [-flexion, -flexion - knee]
    x = limb.thigh * np.sin(swung[0]) + limb.shank * np.sin(swung[1])
    down = limb.below + limb.thigh * np.cos(swung[0]) + limb.shank * np.cos(swung[1])
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    return limb.hip + about_x @ [x, limb.aside, -down]


def test_the_jacobian_is_the_derivative_of_the_foots_place(robot: Robot) -> None:
    rng, e = np.random.default_rng(0), 1e-6
    for limb in limbs_of(robot):
        for _ in range(5):
            angles = np.array([rng.uniform(-0.4, 0.4), rng.uniform(-0.6, 0.6), limb.bend * rng.uniform(0.4, 1.6)])
            moves = [
                (foot_at(limb, angles + e * turn) - foot_at(limb, angles - e * turn)) / (2 * e) for turn in np.eye(3)
            ]
            np.testing.assert_allclose(limb.jacobian(foot_at(limb, angles)), np.transpose(moves), atol=1e-8)


def test_many_feet_at_once(robot: Robot) -> None:
    limb, default = limbs_of(robot)[0], np.array(robot.legs[0].default_foot)
    feet = default + np.random.default_rng(1).uniform(-1, 1, (2, 3, 3)) * robot.box
    expected = [[limb.jacobian(foot) for foot in row] for row in feet]
    np.testing.assert_allclose(limb.jacobian(feet), expected, atol=1e-14)


def test_torques_and_rates_are_the_problems(robot: Robot) -> None:
    """But for the sign of flexion, which is about -y there."""
    rng, sign = np.random.default_rng(2), np.array([1.0, -1.0, -1.0])
    for own, limb, leg in zip(limbs_of(robot), robot.limbs or (), robot.legs, strict=True):
        foot = np.array(leg.default_foot) + rng.uniform(-1, 1, 3) * robot.box
        vector, jacobian = rng.uniform(-10, 10, 3), own.jacobian(foot)
        pose = LegPose(limb, ca.SX(ca.DM(list(foot))))
        column = ca.SX(ca.DM(list(vector)))
        rates = np.linalg.solve(jacobian, vector)
        np.testing.assert_allclose(sign * numbers(pose.torques(column)), jacobian.T @ vector, atol=1e-9)
        np.testing.assert_allclose(sign * numbers(pose.rates(column)), rates, atol=1e-8)
        np.testing.assert_allclose(sign * numbers(pose.inertial_torques(column)), own.inertia @ rates, atol=1e-8)


def test_the_constant_is_the_problems() -> None:
    assert joints.SMOOTH_POWER == energy.SMOOTH_POWER


APEX = 0.05
STRAIGHT = {"speed": 0.7, "cycle_duration": 0.6}


@pytest.mark.parametrize(
    "command",
    [STRAIGHT, STRAIGHT | {"lateral_speed": -0.3}, STRAIGHT | {"yaw_rate": 0.8, "lateral_speed": 0.2}],
    ids=["straight", "sideways", "turning"],
)
def test_heat_of_swings_by_hand(walking: Scenario, command: dict[str, float]) -> None:
    """Of a minimum-jerk way s within d the squared acceleration integrates to 120 / 7 s^2 / d^3.

    Up and down are two ways within half the time: 16 times that of the apex. Both are orthogonal, being even and odd.
    """
    found = Joints.of(walking.as_data() | {"objective": {"joint_heat": 0.02, "joint_work": 0.0}})
    assert found is not None
    task, durations, expected = Task.of(command), np.array([0.1, 0.2, 0.3, 0.5]), 0.0
    for limb, (x, y, z), duration in zip(found.limbs, found.default_feet, durations, strict=True):
        turning = task["yaw_rate"] * np.array([-y, x, 0.0])
        way = 0.6 * (np.array([task["speed"], task["lateral_speed"], 0.0]) + turning)
        torques = limb.inertia @ np.linalg.inv(limb.jacobian(np.array([x, y, z])))
        squares = np.sum((torques @ way) ** 2) + 16 * APEX**2 * np.sum(torques[:, 2] ** 2)
        expected += 0.02 * 120 / 7 * squares / duration**3
    assert found.swings(task, durations, APEX) == pytest.approx(expected, rel=1e-6)


def test_work_of_steps_on_the_spot_by_hand(walking: Scenario) -> None:
    """A foot's highest speed, 1.875 times the mean one, is reached up and down: of each joint half its square twice.

    The mass of the leg, lifted by half the apex, comes on top. A sharp corner, so that numbers are simple.
    """
    found = Joints.of(walking.as_data() | {"objective": {"joint_heat": 0.0, "joint_work": 2.0}})
    assert found is not None
    found = replace(found, smallest=1e-9)
    expected, fastest = 0.0, 1.875 * APEX / 0.1
    for limb, foot in zip(found.limbs, found.default_feet, strict=True):
        rates = np.linalg.inv(limb.jacobian(foot))[:, 2]
        expected += 2.0 * (np.abs(limb.inertia @ rates * rates).sum() * fastest**2 + limb.mass * 9.81 * APEX / 2)
    on_the_spot = Task.of({"speed": 0.0, "cycle_duration": 0.6})
    assert found.swings(on_the_spot, np.full(4, 0.2), APEX) == pytest.approx(expected, rel=1e-3)


def test_only_an_objective_of_energy_has_joints(walking: Scenario) -> None:
    data = walking.as_data()
    found = Joints.of(data)
    assert found is not None
    assert (found.heat, found.work, len(found.limbs)) == (0.02, 1.0, 4)
    assert Joints.of(data | {"objective": {"joint_heat": 0.0, "joint_work": 0.0}}) is None
    assert Joints.of(data | {"objective": {"force": 1.0}}) is None


def test_heat_and_work_of_a_robot_that_stands_and_of_one_that_rises(walking: Scenario) -> None:
    """Heat whether it moves or not; what joints do to a rising body is weight times speed, and back again nothing."""
    found = Joints.of(walking.as_data() | {"objective": {"joint_heat": 0.02, "joint_work": 1.0}})
    assert found is not None
    feet, weight = found.default_feet, walking.robot.mass * 9.81
    forces = np.broadcast_to([0.0, 0.0, weight / 4], feet.shape)
    still = found.standing(feet, np.zeros_like(feet), forces)
    torques = [limb.jacobian(foot).T @ f for limb, foot, f in zip(found.limbs, feet, forces, strict=True)]
    assert still == pytest.approx(0.02 * np.sum(np.square(torques)), rel=1e-12)
    up, down = (found.standing(feet, np.broadcast_to([0.0, 0.0, -v], feet.shape), forces) for v in (0.5, -0.5))
    assert up - down == pytest.approx(weight * 0.5, rel=1e-9)
    assert up > still + 0.5 * weight * 0.5
