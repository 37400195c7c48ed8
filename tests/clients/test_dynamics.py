from __future__ import annotations

import numpy as np
import pytest
from walking_robots import model, planned

from gaitflow.clients.dynamics import Dynamics


@pytest.fixture
def dynamics() -> Dynamics:
    return Dynamics(model(planned("anymal", 0.6, 0.6)))


def moving(dynamics: Dynamics) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    position = np.concatenate([[0.1, 0.2, 0.5], [1.0, 0.02, -0.03, 0.05], dynamics.robot.standing])
    position[3:7] /= np.linalg.norm(position[3:7])
    return position, rng.normal(size=18)


def test_feet_are_put_where_they_are_wanted(dynamics: Dynamics) -> None:
    position, _ = moving(dynamics)
    wanted = dynamics.centres(position) + np.array([0.05, -0.03, 0.04])
    found = dynamics.posed(position[:7], wanted)
    assert dynamics.centres(found) == pytest.approx(wanted, abs=1e-5)


def test_momentum_is_mass_times_velocity(dynamics: Dynamics) -> None:
    position, velocity = moving(dynamics)
    velocity[6:] = 0.0
    standing = np.zeros(4, dtype=bool)
    found = dynamics.at(position, velocity, standing)
    turned = dynamics.at(position, np.concatenate([np.zeros(3), velocity[3:]]), standing)
    assert found.momentum - turned.momentum == pytest.approx(dynamics.robot.mass * velocity[:3], rel=1e-5)


def test_jacobian_and_drift_are_the_derivatives_of_a_centre(dynamics: Dynamics) -> None:
    import mujoco

    position, velocity = moving(dynamics)
    standing = np.zeros(4, dtype=bool)
    step = 1e-6
    here = dynamics.at(position, velocity, standing)
    there = position.copy()
    mujoco.mj_integratePos(dynamics.robot.physics, there, velocity, step)
    later = dynamics.at(there, velocity, standing)
    assert (later.centres - here.centres) / step == pytest.approx(here.jacobian @ velocity, abs=1e-4)
    assert (later.speeds - here.speeds) / step == pytest.approx(here.drift, abs=1e-3)
