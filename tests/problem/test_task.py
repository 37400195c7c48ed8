"""The task as expressions against the task as numbers (`gaitflow.core.twist`, which is held to the exponential)."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from terms import constants, numbers, with_axes

from gaitflow.config.scenario import Scenario
from gaitflow.core import twist
from gaitflow.core.task import AXES, Task
from gaitflow.problem.task import task_parameters

tasks = st.builds(
    lambda v, left, rate, gain: Task.of(
        {"speed": v, "lateral_speed": left, "yaw_rate": rate, "acceleration": gain, "cycle_duration": 0.7}
    ),
    st.floats(-3.0, 3.0),
    st.floats(-2.0, 2.0),
    st.one_of(st.floats(-8.0, 8.0), st.just(0.0), st.floats(-1e-3, 1e-3)),
    st.floats(-2.0, 2.0),
)


@given(tasks, st.floats(0.0, 0.7))
def test_the_frame_is_the_commanded_one(task: Task, time: float) -> None:
    frame, t = constants(task), ca.SX(time)
    np.testing.assert_allclose(numbers(frame.heading(t)), twist.headings(task, np.array(time)), atol=1e-12)
    place = [float(ca.DM(part)) for part in frame.displacement(t)]
    np.testing.assert_allclose(place, twist.displacements(task, np.array(time)), atol=1e-7)
    world = numbers(frame.out_of_frame(frame.velocity(t, 3), t))
    np.testing.assert_allclose(world, [*twist.velocities(task, np.array(time)), 0.0], atol=1e-12)


@given(tasks, st.floats(0.0, 0.7), st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_into_the_frame_and_back(task: Task, time: float, vector: tuple[float, ...]) -> None:
    frame, t = constants(task), ca.SX(time)
    there = frame.into_frame(ca.SX(ca.DM(vector)), t)
    np.testing.assert_allclose(numbers(frame.out_of_frame(there, t)), vector, atol=1e-12)
    assert float(ca.DM(there[2])) == vector[2]
    assert np.linalg.norm(numbers(there)) == pytest.approx(np.linalg.norm(vector))


def test_derivatives_along_a_straight_path_are_finite() -> None:
    """With respect to the yaw rate, too, where the exponential's quotients are 0 over 0."""
    symbols = ca.SX.sym("task", len(AXES))
    frame = type(constants(Task.of({"cycle_duration": 0.6})))({axis: symbols[i] for i, axis in enumerate(AXES)})
    x, y = frame.displacement(frame["cycle_duration"])
    jacobian = ca.Function("jacobian", [symbols], [ca.jacobian(ca.vertcat(x, y), symbols)])
    straight = Task.of({"speed": 1.3, "cycle_duration": 0.6})
    found = dict(zip(AXES, jacobian(straight.parameters).full().T, strict=True))
    np.testing.assert_allclose(found["speed"], [0.6, 0.0], atol=1e-7)
    np.testing.assert_allclose(found["lateral_speed"], [0.0, 0.6], atol=1e-7)
    np.testing.assert_allclose(found["cycle_duration"], [1.3, 0.0], atol=1e-6)
    np.testing.assert_allclose(found["yaw_rate"], [0.0, 1.3 * 0.6**2 / 2], atol=1e-4)


def test_what_does_not_vary_is_no_part_of_the_program(anymal: Scenario) -> None:
    """An axis fixed at 0 is the constant 0; any other value, and a range, is a parameter."""
    symbols = ca.SX.sym("task", len(AXES))
    scenario = with_axes(anymal, slope=0.0, lateral_speed=0.1, acceleration={"start": 0.0, "stop": 1.0, "count": 2})
    values = task_parameters(scenario.tasks, symbols)
    constant = {axis for axis in AXES if values[axis].is_constant()}
    assert constant == {"yaw_rate", "slope", "payload"}
    assert all(values[axis].is_zero() for axis in constant)
