"""The motion between knots against an adaptive integrator; costs and excesses against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bodies import PLANAR, SPATIAL
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gaitflow.core import check
from gaitflow.core.continuous import Motion, between_knots, cost, step_gaps, step_shares
from gaitflow.core.layout import GRAVITY, Layout
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory


def scenario(robot: dict[str, Any], integrator: str = "momentum", **weights: float) -> dict[str, Any]:
    """JSON of a scenario with 2 phases of 3 graded steps."""
    return {
        "robot": robot | {"max_force": 500.0, "max_foot_speed": 8.0, "max_tilt": 1.0},
        "objective": weights,
        "transcription": {
            "phases": 2,
            "knots_per_phase": 3,
            "integrator": integrator,
            "forces": "held" if integrator == "euler" else "linear",
            "grading": 0.7,
            "min_phase_fraction": 0.1,
        },
        "tasks": {"axes": {"speed": {"start": 0.0, "stop": 1.0, "count": 2}, "cycle_duration": 0.6}},
    }


def anywhere(data: dict[str, Any], seed: int) -> Trajectory:
    """Random knots and controls; no motion, but each step is the beginning of one."""
    layout, rng = Layout.of(data), np.random.default_rng(seed)
    w = rng.uniform(-0.4, 0.4, layout.nw)
    w[layout.fractions] = (0.4, 0.6)
    return layout.unpack(w, 0.6)


def glide(data: dict[str, Any], task: Task, **base: float) -> Trajectory:
    """A base that stays level at v along x, feet below it on the ground, a share of the weight on each."""
    layout = Layout.of(data)
    d, legs = layout.dimension, layout.legs
    trajectory = layout.unpack(np.zeros(layout.nw), 1.0)
    durations = task.cycle_duration * np.array([0.4, 0.6])
    times = layout.times(durations)
    default = np.array([leg["default_foot"] for leg in data["robot"]["legs"]])
    trajectory.base[:, 0] = task.speed * times
    trajectory.base[:, d - 1] = 0.5
    trajectory.base[:, layout.nb // 2] = task.speed
    trajectory.feet[:] = trajectory.base[:, None, :d] + default
    trajectory.foot_velocities[..., 0] = task.speed
    for forces in (trajectory.forces, trajectory.end_forces):
        forces[..., -1] = layout.weight / legs
    return replace(trajectory, times=times, durations=durations)


def _simulated(data: dict[str, Any], trajectory: Trajectory, task: Task, k: int, fraction: float) -> Array:
    """Base after part of step k, by an adaptive method on rotation matrices and angular momenta written out here."""
    robot, h = data["robot"], float(np.diff(trajectory.times)[k])
    d = int(robot["dimension"])
    lift = np.eye(3)[:, [0, 2]] if d == 2 else np.eye(3)  # the plane is x and z of space, nose up about -y
    inertia = np.diag([1.0, robot["inertia"][0][0], 1.0]) if d == 2 else np.array(robot["inertia"])
    start, slope = trajectory.base[k], math.radians(task["slope"])
    gravity = -GRAVITY * np.array([math.sin(slope), 0.0, math.cos(slope)])
    angles, omega = ([0.0, -start[2], 0.0], [0.0, -start[5], 0.0]) if d == 2 else (start[3:6], start[9:])
    rotation = Rotation.from_euler("ZYX", angles).as_matrix()
    feet, speeds = trajectory.feet[k] @ lift.T, trajectory.foot_velocities[k] @ lift.T
    first, last = trajectory.forces[k] @ lift.T, trajectory.end_forces[k] @ lift.T

    def rate(t: float, y: Array) -> Array:
        position, turned, momentum = y[:3], y[6:15].reshape(3, 3), y[15:]
        forces = first + t / h * (last - first)
        spin = turned @ np.linalg.solve(inertia, turned.T @ momentum)
        return np.concatenate(
            [
                y[3:6],
                forces.sum(axis=0) / robot["mass"] + gravity,
                np.cross(spin, turned, axisb=0).T.ravel(),
                np.cross(feet + t * speeds - position, forces).sum(axis=0),
            ]
        )

    velocity = start[3:5] if d == 2 else start[6:9]
    before = np.concatenate([lift @ start[:d], lift @ velocity, rotation.ravel(), rotation @ inertia @ np.array(omega)])
    y = solve_ivp(rate, (0.0, fraction * h), before, rtol=1e-11, atol=1e-12).y[:, -1]
    turned = y[6:15].reshape(3, 3)
    after, spin = Rotation.from_matrix(turned).as_euler("ZYX"), np.linalg.solve(inertia, turned.T @ y[15:])
    if d == 2:
        return np.concatenate([y[[0, 2]], [-after[1]], y[[3, 5]], [-spin[1]]])
    return np.concatenate([y[:3], after, y[3:6], spin])


@pytest.mark.parametrize("robot", [PLANAR, SPATIAL], ids=["plane", "space"])
def test_the_motion_within_a_step_is_a_rigid_bodys(robot: dict[str, Any]) -> None:
    """With forces that run linearly and feet that move, up a slope."""
    data, task = scenario(robot), Task.of({"cycle_duration": 0.6, "slope": 15.0})
    trajectory = anywhere(data, 0)
    fractions = np.arange(1, 11) / 10
    seen = Motion.of(data, trajectory, task).at(fractions)
    for k in (0, 2, 4):
        for place in (4, 9):
            expected = _simulated(data, trajectory, task, k, fractions[place])
            # Exact in the plane; in space ten Runge-Kutta steps of a body that is pushed about by its weight.
            np.testing.assert_allclose(seen.base[place, k], expected, atol=1e-8 if len(expected) == 6 else 1e-5)
    gaps = step_gaps(data, trajectory, task)
    np.testing.assert_allclose(gaps, trajectory.base[1:] - seen.base[-1], atol=1e-14)
    shown = between_knots(data, trajectory, task, "/".join(["11"] * len(robot["legs"])))["dynamics"]
    assert shown == pytest.approx(np.abs(gaps[:, : gaps.shape[1] // 2]).max(), rel=1e-12)


def test_a_linear_force_costs_the_integral_of_its_square() -> None:
    """Eq. (8), for a force from a to b: h (a^2 + a b + b^2) / 3."""
    data, task = scenario(PLANAR, force=2.0), Task.of({"cycle_duration": 0.6})
    trajectory = anywhere(data, 1)
    a, b, h = trajectory.forces, trajectory.end_forces, np.diff(trajectory.times)
    expected = 2.0 * (h[:, None, None] * (a**2 + a * b + b**2) / 3).sum()
    assert cost(data, trajectory, task) == pytest.approx(expected, rel=1e-12)


def test_eulers_cost_is_the_papers_sum() -> None:
    weights = {"force": 0.1, "tangential_velocity": 2.0, "normal_velocity": 3.0, "tilt": 5.0, "tilt_rate": 7.0}
    data, task = scenario(PLANAR, "euler", **weights), Task.of({"speed": 0.7, "cycle_duration": 0.6})
    trajectory = anywhere(data, 2)
    v_t, v_n, pitch, rate = (trajectory.base[:-1, index] for index in (3, 4, 2, 5))
    forces = (trajectory.forces**2).sum(axis=(1, 2))
    integrand = 0.1 * forces + 2 * (v_t - 0.7) ** 2 + 3 * v_n**2 + 5 * pitch**2 + 7 * rate**2
    assert cost(data, trajectory, task) == pytest.approx(np.diff(trajectory.times) @ integrand, rel=1e-12)


@pytest.mark.parametrize(("term", "expected"), [
    ("tangential_velocity", 0.2**2 + 0.3**2),  # faster than asked, and sidewards
    ("normal_velocity", 0.4**2),
    ("tilt", 0.1**2),
    ("tilt_rate", 0.0),
    ("lateral_foot", 4 * 0.05**2),
])  # fmt: skip
def test_each_term_in_space(term: str, expected: float) -> None:
    """A yawed base that drifts at a constant velocity while its weight is borne: every integrand is constant."""
    data, task = scenario(SPATIAL, **{term: 3.0}), Task.of({"speed": 0.5, "cycle_duration": 0.6})
    trajectory = glide(data, task)
    trajectory.base[:, 6:9] += (0.2, 0.3, 0.4)
    trajectory.base[:, 3] = 0.1
    trajectory.feet[..., 1] += 0.05
    data["robot"]["inertia"] = (np.eye(3) * 1e30).tolist()  # that no moment turns
    assert cost(data, trajectory, task) == pytest.approx(3.0 * 0.6 * expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("height", [0.0, 0.08])
def test_a_flight_between_knots_leaves_the_box(height: float) -> None:
    """Free fall from knot to knot rises by g h^2 / 8 in between, and its cost is that of the parabola."""
    data, task = scenario(PLANAR, normal_velocity=1.0), Task.of({"speed": 0.5, "cycle_duration": 0.6})
    trajectory = glide(data, task)
    trajectory.forces[:] = trajectory.end_forces[:] = 0.0
    trajectory.base[:, 1] += height
    h = np.diff(trajectory.times)
    trajectory.base[:-1, 4] = GRAVITY * h / 2
    found = between_knots(data, trajectory, task, "00/00")
    rise = GRAVITY * h.max() ** 2 / 8
    assert found["kinematic box"] == pytest.approx(max(0.0, height + rise - 0.1), abs=1e-12)
    assert found["dynamics"] == pytest.approx(0.0, abs=1e-12)
    assert found["friction"] == found["penetration"] == 0.0
    assert cost(data, trajectory, task) == pytest.approx((GRAVITY**2 * h**3 / 12).sum(), rel=1e-12)


def test_friction_and_penetration_between_knots() -> None:
    data, task = scenario(PLANAR), Task.of({"speed": 0.5, "cycle_duration": 0.6, "friction": 0.5})
    trajectory = glide(data, task)
    trajectory.end_forces[1, 0] = (10.0, 8.0)
    trajectory.end_forces[4, 1] = (90.0, 8.0)  # of a leg that swings there: not friction's business
    trajectory.feet[3, 1, 1] -= 0.02
    found = between_knots(data, trajectory, task, "11/10")
    assert found["friction"] == pytest.approx((10.0 - 0.5 * 8.0) / (14.0 * GRAVITY))
    assert found["penetration"] == pytest.approx(0.02)


@pytest.mark.parametrize("grading", [0.0, 0.7, 1.0])
def test_shares_are_those_of_the_layout(grading: float) -> None:
    settings = {"knots_per_phase": 7, "grading": grading}
    layout = Layout(2, 2, 4, 7, 137.0, grading=grading)
    np.testing.assert_allclose(step_shares(settings), layout.shares, atol=1e-15)
    assert step_shares({"knots_per_phase": 4}) == pytest.approx([0.25] * 4)
    assert check.step_shares is step_shares
