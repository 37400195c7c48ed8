from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gaitflow.core.trajectory import Array
from gaitflow.problem.orientation import angle_rates, moment, world_to_base

three = ca.SX.sym("angles", 3)
omega = ca.SX.sym("omega", 3)
rotate = ca.Function("rotate", [three], [world_to_base(three)])
rates = ca.Function("rates", [three, omega], [angle_rates(three, omega)])

wide = st.tuples(st.floats(-3.0, 3.0), st.floats(-1.4, 1.4), st.floats(-3.0, 3.0))  # yaw, pitch, roll


def _to_world(angles: Array) -> Array:
    return Rotation.from_euler("ZYX", angles).as_matrix()


@given(wide)
def test_rotation_is_yaw_pitch_roll(angles: tuple[float, float, float]) -> None:
    found = rotate(angles).full()
    np.testing.assert_allclose(found, _to_world(np.array(angles)).T, atol=1e-14)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(found) == pytest.approx(1.0)


@given(wide, st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_angle_rates_turn_the_base_at_omega(
    angles: tuple[float, float, float], spin: tuple[float, float, float]
) -> None:
    """d/dt R_base->world = R [omega]x, with omega in the base frame; R differentiated numerically."""
    e = 1e-6
    rate = rates(angles, spin).full().ravel()
    numeric = (_to_world(np.array(angles) + e * rate) - _to_world(np.array(angles) - e * rate)) / (2 * e)
    p, q, r = spin
    skew = np.array([[0, -r, q], [r, 0, -p], [-q, p, 0]])
    scale = 1 + np.linalg.norm(rate) ** 3  # of the third derivative, which the central difference leaves out
    np.testing.assert_allclose(numeric, _to_world(np.array(angles)) @ skew, atol=1e-8 * scale)


def test_pitch_in_the_plane_is_positive_nose_up() -> None:
    pitch = ca.SX.sym("pitch")
    turn = ca.Function("turn", [pitch], [world_to_base(pitch)])
    nose = turn(0.3).full().T @ [1.0, 0.0]  # the base's x axis in the world
    assert nose == pytest.approx([np.cos(0.3), np.sin(0.3)])
    assert float(ca.Function("f", [pitch], [angle_rates(pitch, pitch)])(0.7)) == 0.7


def test_moments() -> None:
    """A push up at the front lifts the nose; a push forwards below the body lifts it too. In space: lever x force."""
    assert float(moment(ca.DM([0.5, -0.5]), ca.DM([0.0, 10.0]))) == pytest.approx(5.0)
    assert float(moment(ca.DM([0.5, -0.5]), ca.DM([10.0, 0.0]))) == pytest.approx(5.0)
    lever, force = np.array([0.3, -0.2, -0.4]), np.array([5.0, 7.0, 11.0])
    np.testing.assert_allclose(moment(ca.DM(lever), ca.DM(force)).full().ravel(), np.cross(lever, force))
