"""The commanded twist against the matrix exponential of se(2)."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.core.twist import displacements, headings, velocities

twists = st.builds(
    lambda v, left, rate, gain: Task.of(
        {"speed": v, "lateral_speed": left, "yaw_rate": rate, "acceleration": gain, "cycle_duration": 0.7}
    ),
    st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
    st.one_of(st.floats(-8.0, 8.0), st.just(0.0), st.floats(-1e-4, 1e-4)),
    st.floats(-2.0, 2.0),
)
times = np.array([0.0, 0.1, 0.35, 0.7])


def exponential(task: Task, time: float) -> Array:
    """exp(t xi) [3, 3], xi the twist in se(2)."""
    v, left, rate = task.speed, task["lateral_speed"], task["yaw_rate"]
    return np.asarray(expm(time * np.array([[0.0, -rate, v], [rate, 0.0, left], [0.0, 0.0, 0.0]])))


@given(twists)
def test_the_frame_moves_by_the_exponential_of_the_twist(task: Task) -> None:
    places, turned = displacements(task, times), headings(task, times)
    for time, place, angle in zip(times, places, turned, strict=True):
        frame = exponential(task, time)
        np.testing.assert_allclose(place, frame[:2, 2], atol=1e-9)
        np.testing.assert_allclose([np.cos(angle), np.sin(angle)], frame[:2, 0], atol=1e-12)


@given(twists)
def test_the_velocity_is_the_twists_turned_and_raised(task: Task) -> None:
    """In the frame (v, v_y), and along it more by the acceleration from the middle of the cycle on."""
    for time, velocity in zip(times, velocities(task, times), strict=True):
        turned = exponential(task, time)[:2, :2]
        own = [task.speed + task["acceleration"] * (time - 0.35), task["lateral_speed"]]
        np.testing.assert_allclose(velocity, turned @ own, atol=1e-12)


@given(twists)
def test_without_acceleration_the_velocity_is_the_displacements_rate(task: Task) -> None:
    steady, e = task.replaced(acceleration=0.0), 1e-5
    rate = (displacements(steady, times + e) - displacements(steady, times - e)) / (2 * e)
    np.testing.assert_allclose(velocities(steady, times), rate, atol=1e-6)
