from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gaitflow.config.scenario import Objective, Scenario
from gaitflow.core.trajectory import Array
from gaitflow.core.layout import layout_of
from gaitflow.problem.objectives import integrand

VIBRATION = Objective(tangential_velocity=2.0, normal_velocity=3.0, tilt=5.0, tilt_rate=7.0)


def _value(scenario: Scenario, objective: Objective, x: Array, u: Array, speed: float) -> float:
    return float(ca.DM(integrand(objective, scenario.robot, layout_of(scenario), ca.DM(x), ca.DM(u), ca.DM(speed))))


def test_effort_is_the_sum_of_squared_forces(either: Scenario) -> None:
    """Eq. (8): 3-4-0 makes 25, and foot velocities cost nothing."""
    layout = layout_of(either)
    u = np.full(layout.nu, 9.0)
    u[: layout.legs * layout.dimension] = 0.0
    u[[0, layout.legs * layout.dimension - 1]] = (3.0, 4.0)
    assert _value(either, Objective(force=2.0), np.ones(layout.nx), u, 1.0) == pytest.approx(2 * 25)


def test_vibration_in_the_plane(planar: Scenario) -> None:
    """Eq. (9), with pitch measured from the slope."""
    layout = layout_of(planar)
    x = np.concatenate([[9.0, 9.0, 0.1, 1.5, -0.2, 0.4], np.full(layout.nx - layout.nb, 9.0)])
    expected = 2 * 0.5**2 + 3 * 0.2**2 + 5 * 0.1**2 + 7 * 0.4**2
    assert _value(planar, VIBRATION, x, np.full(layout.nu, 9.0), 1.0) == pytest.approx(expected)


def test_vibration_in_space(anymal: Scenario) -> None:
    """Eq. (10): lateral speed counts as tangential; the rates are those of the angles, not the body rates."""
    layout = layout_of(anymal)
    x = np.zeros(layout.nx)
    angles, rates = np.array([0.3, -0.4, 0.5]), np.array([0.6, -0.7, 0.8])
    e = 1e-6
    before, after = (Rotation.from_euler("ZYX", angles + side * e * rates) for side in (-1, 1))
    x[3:6], x[6:9], x[9:12] = angles, (1.5, 0.3, -0.2), (before.inv() * after).as_rotvec() / (2 * e)
    expected = 2 * (0.5**2 + 0.3**2) + 3 * 0.2**2 + 5 * np.sum(angles**2) + 7 * np.sum(rates**2)
    assert _value(anymal, VIBRATION, x, np.zeros(layout.nu), 1.0) == pytest.approx(expected)


def test_lateral_feet_are_measured_from_their_default(anymal: Scenario) -> None:
    layout = layout_of(anymal)
    x = np.full(layout.nx, 9.0)
    x[layout.nb + 1 :: 3] = [0.199 + 0.1, -0.199, 0.199, -0.199 - 0.2]
    lateral = Objective(lateral_foot=3.0)
    assert _value(anymal, lateral, x, np.zeros(layout.nu), 1.0) == pytest.approx(3 * (0.1**2 + 0.2**2))
