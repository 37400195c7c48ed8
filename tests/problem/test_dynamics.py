"""Eq. (4) against a rigid body written independently: rotation matrix and angular momentum in the level world frame."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gaitflow.config.robot import Robot
from gaitflow.config.scenario import Scenario
from gaitflow.core.trajectory import Array
from gaitflow.problem import integrator
from gaitflow.problem.dynamics import gravity, state_rate
from gaitflow.core.layout import GRAVITY, Layout, layout_of

UP = np.array([0.0, 0.0, 1.0])


def _simulate(
    mass: float, inertia: Array, r: Array, to_world: Array, v: Array, omega: Array, pushes: Callable, time: float
) -> tuple[Array, Array, Array, Array]:
    """Position, R_base->world, velocity and body rates after `time`, gravity along -z; pushes(t) -> points, forces."""

    def rate(t: float, y: Array) -> Array:
        position, rotation, velocity, momentum = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:]
        points, forces = pushes(t)
        spin = rotation @ np.linalg.solve(inertia, rotation.T @ momentum)
        return np.concatenate(
            [
                velocity,
                np.cross(spin, rotation, axisb=0).T.ravel(),
                forces.sum(axis=0) / mass - GRAVITY * UP,
                np.cross(points - position, forces).sum(axis=0),
            ]
        )

    start = np.concatenate([r, to_world.ravel(), v, to_world @ inertia @ omega])
    end = solve_ivp(rate, (0.0, time), start, rtol=1e-11, atol=1e-12).y[:, -1]
    rotation = end[3:12].reshape(3, 3)
    return end[:3], rotation, end[12:15], np.linalg.solve(inertia, rotation.T @ end[15:])


def _ours(scenario: Scenario, x: Array, u: Array, time: float, steps: int, rule: str) -> Array:
    layout = layout_of(scenario)
    state, control, h = ca.SX.sym("x", layout.nx), ca.SX.sym("u", layout.nu), ca.SX.sym("h")
    stepped = integrator.step(
        rule, lambda s: state_rate(scenario.robot, scenario.terrain.slope_deg, layout, s, control), state, h
    )
    end = ca.Function("step", [state, control, h], [stepped]).mapaccum(steps)(
        x, np.tile(u[:, None], steps), time / steps
    )
    return end.full()[:, -1]


def _random_motion(layout: Layout, robot: Robot, seed: int) -> tuple[Array, Array]:
    """A state far from upright and a control that pushes and moves every foot."""
    rng = np.random.default_rng(seed)
    default = np.array([leg.default_foot for leg in robot.legs])
    base = np.concatenate(
        [
            rng.uniform(-1, 1, layout.dimension),
            rng.uniform(-1, 1, layout.angles),
            rng.uniform(-2, 2, layout.dimension),
            rng.uniform(-3, 3, layout.angles),
        ]
    )
    feet = base[: layout.dimension] + default + rng.uniform(-0.2, 0.2, default.shape)
    forces = rng.uniform(-0.3, 0.3, default.shape) * layout.weight
    return np.append(base, feet), np.append(forces, rng.uniform(-2, 2, default.shape))


def _expected(scenario: Scenario, x: Array, u: Array, time: float) -> Array:
    """The state after `time` by the independent body: into the level world, simulate, back along the slope."""
    layout, robot = layout_of(scenario), scenario.robot
    d, a, legs = layout.dimension, layout.angles, layout.legs
    slope = np.radians(scenario.terrain.slope_deg)
    tilted = Rotation.from_euler("y", -slope).as_matrix()  # the ground's x axis points uphill
    lift = np.eye(3)[:, [0, 2]] if d == 2 else np.eye(3)  # the plane is x and z of space, nose up about -y
    inertia = np.diag([1.0, robot.inertia[0][0], 1.0]) if d == 2 else np.array(robot.inertia)
    angles = np.array([0.0, -x[2], 0.0]) if d == 2 else x[3:6]
    rates = np.array([0.0, -x[5], 0.0]) if d == 2 else x[9:12]
    in_space = lambda vectors: np.atleast_2d(vectors) @ lift.T @ tilted.T  # noqa: E731
    feet, forces, speeds = (values.reshape(legs, d) for values in (x[layout.nb :], u[: legs * d], u[legs * d :]))
    position, rotation, velocity, spin = _simulate(
        robot.mass, inertia,
        in_space(x[:d])[0], tilted @ Rotation.from_euler("ZYX", angles).as_matrix(),
        in_space(x[d + a : 2 * d + a])[0], rates,
        lambda t: (in_space(feet + t * speeds), in_space(forces)), time,
    )  # fmt: skip
    yaw_pitch_roll = Rotation.from_matrix(tilted.T @ rotation).as_euler("ZYX")
    turned, spun = (-yaw_pitch_roll[[1]], -spin[[1]]) if d == 2 else (yaw_pitch_roll, spin)
    back = lift.T @ tilted.T
    return np.concatenate([back @ position, turned, back @ velocity, spun, (feet + time * speeds).ravel()])


@pytest.mark.parametrize(("rule", "order", "steps"), [("euler", 1, 400), ("rk4", 4, 4)])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_converges_to_an_independent_rigid_body(either: Scenario, rule: str, order: int, steps: int, seed: int) -> None:
    x, u = _random_motion(layout_of(either), either.robot, seed)
    time = 0.1
    expected = _expected(either, x, u, time)
    coarse, fine = (np.abs(_ours(either, x, u, time, n, rule) - expected).max() for n in (steps, 2 * steps))
    assert fine < (1e-2 if rule == "euler" else 1e-4)
    exact = coarse < 1e-9  # in the plane the motion under held forces is a polynomial of degree 4
    assert exact if rule == "rk4" and layout_of(either).dimension == 2 else not exact
    assert exact or np.log2(coarse / fine) == pytest.approx(order, abs=0.5)


def test_a_free_top_keeps_energy_and_momentum(small_anymal: Scenario) -> None:
    """Without forces an asymmetric body tumbles; in space its momentum stands still."""
    layout, inertia = layout_of(small_anymal), np.array(small_anymal.robot.inertia)
    x = np.zeros(layout.nx)
    x[3:6], x[9:12] = (0.4, -0.5, 0.8), (3.0, 0.5, -2.0)
    after = _ours(small_anymal, x, np.zeros(layout.nu), 0.5, 200, "rk4")

    def momentum(state: Array) -> Array:
        return Rotation.from_euler("ZYX", state[3:6]).as_matrix() @ inertia @ state[9:12]

    assert np.abs(after[9:12] - x[9:12]).max() > 0.5  # it does tumble
    np.testing.assert_allclose(momentum(after), momentum(x), atol=1e-7)
    assert after[9:12] @ inertia @ after[9:12] == pytest.approx(x[9:12] @ inertia @ x[9:12], rel=1e-8)


def test_the_slope_turns_gravity() -> None:
    """Uphill is forwards: gravity pulls back along the ground, and is never more or less than g."""
    along, normal = gravity(2, 20.0)
    assert (along, normal) == pytest.approx((-3.355218, -9.218385), abs=1e-6)
    assert gravity(3, 20.0) == pytest.approx([along, 0.0, normal])
    assert gravity(2, 0.0) == pytest.approx([0.0, -GRAVITY])
