from __future__ import annotations

import mujoco
import numpy as np
import pytest
from walking_robots import model, planned

from gaitflow.clients.description import describe
from gaitflow.clients.robot_model import RobotModel


@pytest.mark.parametrize("name", ["anymal", "go1"])
def test_mass_centre_inertia_and_feet_are_the_robot_files(name: str) -> None:
    motion = planned(name, 0.6, 0.6)
    robot, stated = model(motion), motion.scenario["robot"]
    data = mujoco.MjData(robot.physics)
    data.qpos[3] = 1.0
    data.qpos[7:] = robot.standing
    mujoco.mj_forward(robot.physics, data)
    assert robot.physics.body_mass.sum() == pytest.approx(stated["mass"], abs=1e-4)
    centre = np.array(stated["frames"]["com_in_base"])
    assert data.subtree_com[0] == pytest.approx(centre, abs=1e-4)
    mass = np.zeros((robot.physics.nv, robot.physics.nv))
    mujoco.mj_fullM(robot.physics, data, mass)
    about_origin = stated["mass"] * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    assert mass[3:6, 3:6] - about_origin == pytest.approx(np.array(stated["inertia"]), abs=0.002)
    for leg, expected in zip(robot.legs, stated["legs"], strict=True):
        foot = data.xpos[leg.body]
        assert leg.name == expected["name"]
        assert foot == pytest.approx(expected["default_foot"] + centre, abs=1e-3)
        assert data.geom_xpos[leg.geom] - foot == pytest.approx(leg.standing, abs=1e-6)


def test_slope_friction_and_payload_are_the_tasks() -> None:
    motion = planned("anymal", 0.6, 0.6)
    task = motion.task.replaced(slope=10.0, friction=0.4, payload=5.0)
    robot = RobotModel.of(describe(motion.scenario), motion.scenario, task)
    assert robot.physics.opt.gravity == pytest.approx(
        [-9.81 * np.sin(np.deg2rad(10)), 0, -9.81 * np.cos(np.deg2rad(10))]
    )
    assert robot.physics.geom_friction[:, 0] == pytest.approx(0.4)
    assert robot.physics.body_mass.sum() == pytest.approx(35.475, abs=1e-3)
    assert robot.mass == pytest.approx(35.475, abs=1e-3)


def test_motors_have_the_urdfs_limits() -> None:
    assert model(planned("anymal", 0.6, 0.6)).effort == pytest.approx(80.0)
    assert model(planned("go1", 0.6, 0.6)).effort == pytest.approx(np.tile([23.7, 23.7, 35.55], 4))
