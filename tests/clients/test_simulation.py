from __future__ import annotations

import numpy as np
import pytest
from walking_robots import model, planned

from gaitflow.clients.simulation import AS_PLANNED, Conditions, Push, Simulation
from gaitflow.clients.walking import Walker, started
from gaitflow.motion import Motion, standing


def test_standing_robot_stays_and_its_feet_carry_the_weight() -> None:
    motion = standing(planned("anymal", 0.6, 0.6))
    walker = Walker(model(motion), motion)
    while walker.time < 1.0:
        walker.advance()
    measured = walker.simulation.measured
    assert walker.simulation.forces.sum(axis=0) == pytest.approx([0, 0, walker.robot.mass * 9.81], abs=3.0)
    assert measured.touching.all()
    assert np.abs(measured.position[:3] - motion.at(1.0).position).max() < 2e-3
    assert np.abs(measured.velocity).max() < 0.01


def test_robot_stands_on_a_slope() -> None:
    level = planned("anymal", 0.6, 0.6)
    task = level.task.replaced(slope=10.0)
    motion = standing(Motion.of(level.scenario, level.trajectory, task, level.pattern, point="base"))
    walker = Walker(model(motion), motion)
    while walker.time < 0.5:
        walker.advance()
    weight = walker.robot.mass * 9.81
    uphill, normal = weight * np.sin(np.deg2rad(10.0)), weight * np.cos(np.deg2rad(10.0))
    assert walker.simulation.forces.sum(axis=0) == pytest.approx([uphill, 0.0, normal], abs=3.0)
    assert np.abs(walker.simulation.measured.position[:3] - motion.at(0.5).position).max() < 5e-3


def test_torques_act_late_and_within_their_limits() -> None:
    motion = standing(planned("anymal", 0.6, 0.6))
    robot = model(motion)
    position, velocity = started(robot, motion)
    simulation = Simulation(robot, position, velocity, Conditions(delay=0.005))
    acted = []
    for _ in range(8):
        simulation.step(np.full(12, 200.0))
        acted.append(simulation.torque[0])
    assert acted == [0.0] * 5 + [80.0] * 3


def test_push_changes_the_velocity_of_the_base() -> None:
    motion = standing(planned("anymal", 0.6, 0.6))
    robot = model(motion)
    position, velocity = started(robot, motion)
    pushed = Simulation(robot, position, velocity, Conditions(pushes=(Push(0.002, (0.0, 0.3, 0.0)),)))
    left_alone = Simulation(robot, position, velocity, AS_PLANNED)
    for _ in range(3):
        pushed.step(np.zeros(12))
        left_alone.step(np.zeros(12))
    assert pushed.measured.velocity[1] - left_alone.measured.velocity[1] == pytest.approx(0.3, abs=0.15)


def test_conditions_leave_the_robots_own_model_alone() -> None:
    motion = standing(planned("anymal", 0.6, 0.6))
    robot = model(motion)
    position, velocity = started(robot, motion)
    heavier = Simulation(robot, position, velocity, Conditions(friction=0.3, mass_factor=1.1))
    assert heavier._model.body_mass.sum() == pytest.approx(1.1 * robot.mass, rel=1e-6)
    assert robot.physics.body_mass.sum() == pytest.approx(robot.mass, rel=1e-6)
    assert robot.physics.geom_friction[:, 0] == pytest.approx(0.8)


@pytest.mark.parametrize("wrong", [{"friction": 0.0}, {"mass_factor": -1.0}, {"delay": 2.0}])
def test_conditions_that_are_none_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Conditions(**wrong)
