"""Eq. (4) against a rigid body written independently: rotation matrix and angular momentum in the level world frame."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from rigid_motion import random_motion, simulated
from terms import constants, layout_of, node_of, numbers

from gaitflow.config.scenario import Scenario
from gaitflow.core.layout import GRAVITY
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.problem.dynamics import Node, body_of

SLOPED = Task.of({"cycle_duration": 0.6, "slope": 15.0})


def differences(scenario: Scenario, motion: Callable[[float], Array], time: float) -> tuple[Array, Array]:
    """First and second derivative of the base [nb] of a motion, by central differences."""
    e = 3e-4
    before, here, after = (motion(time + side * e) for side in (-1, 0, 1))
    return (after - before) / (2 * e), (after - 2 * here + before) / e**2


def node_at(scenario: Scenario, x: Array, forces: Array) -> Node:
    return node_of(body_of(scenario.robot, constants(SLOPED)), x, forces)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_rates_are_those_of_an_independent_rigid_body(either: Scenario, seed: int) -> None:
    """Under held forces with feet that move: derivatives of the simulated base, and those of its angles twice."""
    layout = layout_of(either)
    x, forces, speeds = random_motion(layout, either.robot, seed)
    motion = lambda t: simulated(either.robot, 15.0, x, forces, forces, speeds, 1.0, t)  # noqa: E731
    first, second = differences(either, lambda t: motion(t)[: layout.nb], 0.0)
    node = node_at(either, x, forces)
    np.testing.assert_allclose(numbers(node.rate), first, rtol=1e-3, atol=1e-3)
    angles = slice(layout.dimension, layout.dimension + layout.angles)
    np.testing.assert_allclose(numbers(node.angle_accelerations), second[angles], rtol=1e-2, atol=1e-2)
    np.testing.assert_array_equal(numbers(node.base), x[: layout.nb])


def test_angular_momentum_changes_by_the_moments_about_the_origin(either: Scenario) -> None:
    layout, robot, e = layout_of(either), either.robot, 1e-4
    x, forces, speeds = random_motion(layout, robot, 3)
    momenta = [
        numbers(node_at(either, simulated(robot, 15.0, x, forces, forces, speeds, 1.0, t), forces).angular_momentum)
        for t in (-e, e)
    ]
    node = node_at(either, x, forces)
    position, gravity = x[: layout.dimension], numbers(node.body.gravity)
    points = np.vstack([x[layout.nb :].reshape(forces.shape), position])
    pushes = np.vstack([forces, robot.mass * gravity])
    if layout.dimension == 2:
        expected = (points[:, 0] * pushes[:, 1] - points[:, 1] * pushes[:, 0]).sum(keepdims=True)
    else:
        expected = np.cross(points, pushes).sum(axis=0)
    np.testing.assert_allclose((momenta[1] - momenta[0]) / (2 * e), expected, rtol=1e-5, atol=1e-4)


def test_a_free_top_keeps_energy(small_anymal: Scenario) -> None:
    """Without forces an asymmetric body tumbles: I omega is perpendicular to what changes its energy."""
    x = np.zeros(24)
    x[3:6], x[9:12] = (0.4, -0.5, 0.8), (3.0, 0.5, -2.0)
    node = node_at(small_anymal, x, np.zeros((4, 3)))
    spin = numbers(node.angular_acceleration)
    assert np.abs(spin).max() > 0.5
    assert x[9:12] @ np.array(small_anymal.robot.inertia) @ spin == pytest.approx(0.0, abs=1e-12)


def test_the_slope_turns_gravity(planar: Scenario, anymal: Scenario) -> None:
    """Uphill is forwards: gravity pulls back along the ground, and is never more or less than g."""
    steep = constants(SLOPED.replaced(slope=20.0))
    along, normal = numbers(body_of(planar.robot, steep).gravity)
    assert (along, normal) == pytest.approx((-3.355218, -9.218385), abs=1e-6)
    assert numbers(body_of(anymal.robot, steep).gravity) == pytest.approx([along, 0.0, normal])
    level = constants(SLOPED.replaced(slope=0.0))
    assert numbers(body_of(planar.robot, level).gravity) == pytest.approx([0.0, -GRAVITY])


def test_a_robots_mean_inertia_scales_its_momentum(planar: Scenario, small_anymal: Scenario) -> None:
    assert body_of(planar.robot, constants(SLOPED)).mean_inertia == planar.robot.inertia[0][0]
    assert body_of(small_anymal.robot, constants(SLOPED)).mean_inertia == pytest.approx((1.004 + 2.078 + 2.082) / 3)
    assert ca.DM(body_of(small_anymal.robot, constants(SLOPED)).mass) == small_anymal.robot.mass
