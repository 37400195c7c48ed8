"""Frames on the ground against the matrix exponential of se(2), and as a group."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from gaitflow.core.rigid_body import Attitude
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.motion.orientation import quaternions
from gaitflow.motion.place import Place

small = st.floats(-2.0, 2.0)
places = st.builds(lambda x, y, heading: Place(complex(x, y), heading), small, small, st.floats(-7.0, 7.0))
seeds = st.integers(0, 2**31)


def vectors(seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=(4, 2, 3))


@given(small, small, small, st.floats(0.0, 5.0))
def test_the_commanded_place_is_the_twists_exponential(v: float, left: float, rate: float, time: float) -> None:
    task = Task.of({"speed": v, "lateral_speed": left, "yaw_rate": rate, "cycle_duration": 0.6})
    frame = expm(time * np.array([[0.0, -rate, v], [rate, 0.0, left], [0.0, 0.0, 0.0]]))
    found = Place.commanded(task, time).points(np.array([[0.3, -0.2, 0.1]]))[0]
    np.testing.assert_allclose(found, [*(frame @ [0.3, -0.2, 1.0])[:2], 0.1], atol=1e-9)
    assert Place.commanded(task, time).heading == rate * time


@given(places, places, seeds)
def test_places_are_a_group(one: Place, other: Place, seed: int) -> None:
    asked = vectors(seed)
    np.testing.assert_allclose(one.of(other).points(asked), one.points(other.points(asked)), atol=1e-12)
    np.testing.assert_allclose(one.of(one.inverse).points(asked), asked, atol=1e-12)
    np.testing.assert_allclose(one.inverse.directions(one.directions(asked)), asked, atol=1e-12)


@given(places, seeds)
def test_orientations_turn_with_their_angles(place: Place, seed: int) -> None:
    """The quaternion, sign and all, is that of the base state that the place moves."""
    base = np.random.default_rng(seed).normal(0, 0.4, (5, 12))
    moved = place.bodies(base)
    np.testing.assert_allclose(
        place.orientations(quaternions(base[:, 3:6])), quaternions(moved[:, 3:6]), atol=1e-12
    )  # fmt: skip
    seen = Attitude(moved[:, 3:6]).into_base(moved[:, 6:9])
    np.testing.assert_allclose(seen, Attitude(base[:, 3:6]).into_base(base[:, 6:9]), atol=1e-12)


def test_the_plane_has_no_heading() -> None:
    place = Place(2.0 + 0j)
    np.testing.assert_array_equal(place.points(np.array([1.0, 0.5])), [3.0, 0.5])
    np.testing.assert_array_equal(place.bodies(np.arange(6.0)), [2.0, 1.0, 2.0, 3.0, 4.0, 5.0])
