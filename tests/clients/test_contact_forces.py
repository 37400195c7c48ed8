from __future__ import annotations

import numpy as np
import pytest
from walking_robots import model, planned

from gaitflow.clients.body_target import BodyTarget
from gaitflow.clients.contact_forces import contact_forces
from gaitflow.clients.dynamics import Dynamics
from gaitflow.clients.simulation import AS_PLANNED, Simulation
from gaitflow.clients.walking import started
from gaitflow.motion import standing

AT_REST = BodyTarget(np.zeros(3), np.zeros(3))


@pytest.fixture
def pose():
    motion = planned("anymal", 0.6, 0.6)
    robot = model(motion)
    position, velocity = started(robot, standing(motion))
    return robot, position, velocity


def test_physics_gives_the_forces_that_were_solved_for(pose) -> None:
    robot, position, velocity = pose
    equations = Dynamics(robot).at(position, velocity, np.ones(4, dtype=bool))
    target = BodyTarget(np.array([20.0, -10.0, 330.0]), np.array([1.5, -2.0, 1.0]))
    found = contact_forces(robot, equations, np.ones(4, dtype=bool), np.zeros((4, 3)), target, np.zeros((4, 3)))
    assert found.limited
    assert found.forces.sum(axis=0) == pytest.approx(target.force, rel=0.03, abs=0.5)
    pushes = np.concatenate([np.zeros(6), found.torque])
    pushes += np.einsum("lij,li->j", equations.jacobian, found.forces) - equations.bias
    accelerations = np.linalg.solve(equations.mass, pushes)
    assert accelerations[3:6] == pytest.approx(target.angular_acceleration, rel=0.1, abs=0.1)
    assert equations.jacobian @ accelerations + equations.drift == pytest.approx(np.zeros((4, 3)), abs=1e-3)
    simulation = Simulation(robot, position, velocity, AS_PLANNED)
    for _ in range(30):
        simulation.step(found.torque)
    assert simulation.forces == pytest.approx(found.forces, rel=0.05, abs=2.0)


def test_forces_stay_in_the_cone_and_torques_in_their_limits(pose) -> None:
    robot, position, velocity = pose
    stands = np.array([True, False, False, True])
    equations = Dynamics(robot).at(position, velocity, stands)
    target = BodyTarget(np.array([900.0, 0.0, 1500.0]), np.zeros(3))
    found = contact_forces(robot, equations, stands, np.zeros((4, 3)), target, np.zeros((4, 3)))
    assert found.forces[[1, 2]] == pytest.approx(0.0)
    assert (np.hypot(*found.forces[stands, :2].T) <= robot.friction * found.forces[stands, 2] + 1e-6).all()
    own = np.concatenate([robot.legs[leg].velocities - 6 for leg in (0, 3)])
    assert np.abs(found.torque[own]).max() == pytest.approx(80.0)


def test_in_flight_there_are_torques_and_no_forces(pose) -> None:
    robot, position, velocity = pose
    flight = np.zeros(4, dtype=bool)
    equations = Dynamics(robot).at(position, velocity, flight)
    found = contact_forces(robot, equations, flight, np.full((4, 3), 5.0), AT_REST, np.zeros((4, 3)))
    assert not found.forces.any()
    assert np.isfinite(found.torque).all() and np.abs(found.torque).max() > 0.1
