from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation
from terms import layout_of, numbers

from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array
from gaitflow.problem.kinematics import foot_offsets


def _offsets(scenario: Scenario, x: Array) -> Array:
    layout = layout_of(scenario)
    d, a = layout.dimension, layout.angles
    feet = [ca.SX(ca.DM(foot)) for foot in x[layout.nb :].reshape(layout.legs, d)]
    return numbers(foot_offsets(scenario.robot, ca.SX(ca.DM(x[:d])), ca.SX(ca.DM(x[d : d + a])), feet)).reshape(-1, d)


def test_a_foot_fixed_to_the_base_stays_at_its_offset(either: Scenario) -> None:
    """However the base lies and turns, a foot carried rigidly at default + e is e away from its default."""
    layout, rng = layout_of(either), np.random.default_rng(0)
    d, a = layout.dimension, layout.angles
    default = np.array([leg.default_foot for leg in either.robot.legs])
    for _ in range(5):
        x = rng.uniform(-1, 1, layout.nx)
        angles = x[d : d + a]
        if d == 2:  # nose up
            c, s = np.cos(angles[0]), np.sin(angles[0])
            to_world = np.array([[c, -s], [s, c]])
        else:
            to_world = Rotation.from_euler("ZYX", angles).as_matrix()
        carried = rng.uniform(-0.2, 0.2, default.shape)
        x[layout.nb :] = (x[:d] + (default + carried) @ to_world.T).ravel()
        np.testing.assert_allclose(_offsets(either, x), carried, atol=1e-14)
