from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm
from terms import constants, layout_of, numbers

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.problem.periodicity import periodicity_rows


def closing(scenario: Scenario, first: Array, last: Array, task: Task) -> Array:
    layout = layout_of(scenario)
    return numbers(periodicity_rows(layout, ca.SX(ca.DM(first)), ca.SX(ca.DM(last)), constants(task)))


def test_everything_repeats_but_the_way_forward(either: Scenario) -> None:
    """Eq. (3): base and feet advance by v T along the ground; sideways, heights, angles and velocities repeat."""
    layout, task = layout_of(either), Task.of({"speed": 1.3, "cycle_duration": 0.7})
    first = np.random.default_rng(0).normal(size=layout.nx)
    ahead = np.zeros(layout.nx)
    ahead[[0, *(layout.nb + layout.dimension * np.arange(layout.legs))]] = 1.3 * 0.7
    np.testing.assert_allclose(closing(either, first, first + ahead, task), 0, atol=1e-14)
    for index in range(layout.nx):
        last = first + ahead
        last[index] += 0.25
        off = closing(either, first, last, task)
        np.testing.assert_allclose(off, 0.25 * (np.arange(layout.nx) == index), atol=1e-14)


def test_a_cycle_may_end_faster_than_it_began(planar: Scenario) -> None:
    layout = layout_of(planar)
    task = Task.of({"speed": 1.3, "acceleration": -0.5, "cycle_duration": 0.7})
    first = np.random.default_rng(0).normal(size=layout.nx)
    expected = np.zeros(layout.nx)
    expected[[0, layout.nb, layout.nb + 2]] = 1.3 * 0.7
    expected[3] = -0.5 * 0.7
    np.testing.assert_allclose(closing(planar, first, first + expected, task), 0, atol=1e-14)


@pytest.mark.parametrize("rate", [0.9, -2.0, 1e-6, 0.0])
def test_base_and_feet_are_the_first_ones_moved_by_the_exponential(anymal: Scenario, rate: float) -> None:
    """exp(T xi) of the commanded twist, from scipy; velocities turned alike and raised along the heading."""
    layout, cycle = layout_of(anymal), 0.7
    axes = {"speed": 0.8, "lateral_speed": -0.3, "yaw_rate": rate, "acceleration": 0.6, "cycle_duration": cycle}
    twist = np.array([[0, -rate, 0, 0.8], [rate, 0, 0, -0.3], [0, 0, 0, 0], [0, 0, 0, 0]])
    frame = expm(cycle * twist)
    first = np.random.default_rng(0).normal(size=layout.nx)

    def moved(point: Array) -> Array:
        return np.asarray(frame @ np.append(point, 1.0))[:3]

    last = np.concatenate(
        [
            moved(first[:3]),
            first[3:6] + np.array([rate * cycle, 0, 0]),
            frame[:3, :3] @ (first[6:9] + np.array([0.6 * cycle, 0, 0])),
            first[9:12],  # in the base frame
            *(moved(foot) for foot in first[12:].reshape(4, 3)),
        ]
    )
    np.testing.assert_allclose(closing(anymal, first, last, Task.of(axes)), 0, atol=1e-7)
    for index in range(layout.nx):
        other = last.copy()
        other[index] += 0.25
        off = closing(anymal, first, other, Task.of(axes))
        np.testing.assert_allclose(off, 0.25 * (np.arange(layout.nx) == index), atol=1e-7)
