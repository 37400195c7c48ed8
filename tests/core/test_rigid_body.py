"""The check's mechanics against scipy's rotations and against differences."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import PLANAR, SPATIAL
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gaitflow.core.rigid_body import Attitude, G, RigidBody, moment
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array

angles = st.tuples(st.floats(-3.0, 3.0), st.floats(-1.3, 1.3), st.floats(-3.0, 3.0))
vectors = st.tuples(*[st.floats(-5.0, 5.0)] * 3)


def task(slope: float = 0.0) -> Task:
    return Task.of({"cycle_duration": 0.6, "slope": slope})


def to_world(yaw_pitch_roll: Array) -> Array:
    return np.asarray(Rotation.from_euler("ZYX", yaw_pitch_roll).as_matrix())


@given(angles, vectors)
def test_vectors_turn_with_the_base(yaw_pitch_roll: tuple[float, ...], vector: tuple[float, ...]) -> None:
    attitude, rotation = Attitude(np.array(yaw_pitch_roll)), to_world(np.array(yaw_pitch_roll))
    np.testing.assert_allclose(attitude.into_world(np.array(vector)), rotation @ vector, atol=1e-13)
    np.testing.assert_allclose(attitude.into_base(np.array(vector)), rotation.T @ vector, atol=1e-13)


@given(angles, vectors, vectors)
def test_rates_and_accelerations_of_the_angles(
    at: tuple[float, ...], omega: tuple[float, ...], spin: tuple[float, ...]
) -> None:
    """A body at `at` that turns at omega + spin t in its own frame, a moment earlier and later."""
    attitude, e = Attitude(np.array(at)), 1e-4
    rates = attitude.rates(np.array(omega))
    change = attitude.accelerations(np.array(omega), np.array(spin))
    scale = (1 + np.abs(rates).max()) ** 3
    before, after = (
        Rotation.from_euler("ZYX", np.array(at) + side * e * rates + e**2 / 2 * change) for side in (-1, 1)
    )
    turned = (before.inv() * after).as_rotvec() / (2 * e)
    np.testing.assert_allclose(turned, omega, atol=1e-6 * scale)
    rates_then = [
        Attitude(np.array(at) + side * e * rates).rates(np.array(omega) + side * e * np.array(spin)) for side in (-1, 1)
    ]
    np.testing.assert_allclose((rates_then[1] - rates_then[0]) / (2 * e), change, atol=1e-5 * scale**2, rtol=1e-4)


def test_many_vectors_share_one_attitude() -> None:
    rng = np.random.default_rng(0)
    at, feet = rng.uniform(-1, 1, (5, 3)), rng.normal(size=(5, 4, 3))
    found = Attitude(at).into_base(feet)
    for k in range(5):
        np.testing.assert_allclose(found[k], feet[k] @ to_world(at[k]), atol=1e-14)


def test_pitch_in_the_plane_is_nose_up() -> None:
    """A point that the base carries a metre ahead goes up with the pitch."""
    ahead = np.array([np.cos(0.3), np.sin(0.3)])
    np.testing.assert_allclose(Attitude(np.array([0.3])).into_base(ahead), [1.0, 0.0], atol=1e-15)
    assert moment(np.array([0.5, -0.5]), np.array([0.0, 10.0])) == pytest.approx(5.0)
    lever, force = np.array([0.3, -0.2, -0.4]), np.array([5.0, 7.0, 11.0])
    np.testing.assert_allclose(moment(lever, force), np.cross(lever, force))


def test_the_slope_turns_gravity() -> None:
    """Uphill is forwards: gravity pulls back along the ground, and is never more or less than g."""
    body = RigidBody.of(SPATIAL, task(20.0))
    np.testing.assert_allclose(body.gravity, [-3.355218, 0.0, -9.218385], atol=1e-6)
    np.testing.assert_allclose(RigidBody.of(PLANAR, task(20.0)).gravity, body.gravity[[0, 2]])
    np.testing.assert_allclose(RigidBody.of(PLANAR, task()).gravity, [0.0, -G])
    assert RigidBody.of(PLANAR, task(20.0)).weight == pytest.approx(14.0 * G)


def test_a_feets_box_turns_and_moves_with_the_base() -> None:
    body, rng = RigidBody.of(SPATIAL, task()), np.random.default_rng(1)
    at, position = rng.uniform(-0.5, 0.5, 3), rng.normal(size=3)
    off = np.zeros((4, 3))
    off[2, 1] = 0.13
    feet = position + (body.default_feet + off) @ to_world(at).T
    excess = body.box_excess(position, at, feet)
    expected = np.abs(off) - [0.2, 0.1, 0.05]
    np.testing.assert_allclose(excess, expected, atol=1e-15)


def test_momentum_changes_by_moment_and_gravity() -> None:
    """d/dt of the angular momentum about the origin is the moment of all forces about it: Euler's equation."""
    body, rng, e = RigidBody.of(SPATIAL, task(10.0)), np.random.default_rng(2), 1e-5
    base = rng.uniform(-1, 1, 12)
    feet, forces = rng.normal(size=(4, 3)), rng.normal(size=(4, 3)) * 100
    rate = body.rate(base, feet, forces)
    change = (body.angular_momentum(base + e * rate) - body.angular_momentum(base - e * rate)) / (2 * e)
    pulls = np.cross(feet, forces).sum(axis=0) + 30.0 * np.cross(base[:3], body.gravity)
    np.testing.assert_allclose(change, pulls, rtol=1e-6)
