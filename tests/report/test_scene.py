"""A motion in space: poses, the plane as a slice of space, and the camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitflow.config.scenario import Transcription
from gaitflow.report.scene import camera, rotation_of, scene_of


def test_a_planar_robot_pitches_nose_up_in_space(solution_of, scenario) -> None:
    solution = solution_of(1.5, 0.8, "gallop")
    scene = scene_of(solution, scenario)
    step = int(np.argmax(solution.trajectory.base[:, 2]))
    pose = scene.at(float(scene.times[step]))
    assert scene.planar and solution.trajectory.base[step, 2] > 0.05
    nose = pose.rotation @ [1.0, 0.0, 0.0]
    assert np.arctan2(nose[2], nose[0]) == pytest.approx(solution.trajectory.base[step, 2])
    assert (pose.feet[:, 1] == 0).all() and (pose.hips[:, 1] == 0).all()


def test_poses_at_knots_are_the_stored_ones(trot, anymal) -> None:
    scene, trajectory = scene_of(trot, anymal), trot.trajectory
    for step in (0, 7, 25, 39):
        pose = scene.at(float(trajectory.times[step]))
        np.testing.assert_allclose(pose.position, trajectory.base[step, :3], atol=1e-12)
        np.testing.assert_allclose(pose.feet, trajectory.feet[step], atol=1e-12)
        np.testing.assert_array_equal(pose.forces, trajectory.forces[step])
    middle = scene.at(float(trajectory.times[7:9].mean()))
    np.testing.assert_allclose(middle.position, trajectory.base[7:9, :3].mean(axis=0), atol=1e-12)


def test_between_knots_an_exact_motion_is_where_its_forces_bring_it(solution_of, scenario) -> None:
    """r(t) = r_0 + v_0 t + a_0 t^2 / 2 + (a_1 - a_0) t^3 / 6 h on ground of 10 degrees; forward Euler goes straight."""
    rng = np.random.default_rng(1)
    solution = solution_of(1.5, 0.8, "gallop")
    task, stored = solution.task.replaced(slope=10.0), solution.trajectory
    h = np.diff(stored.times)[:, None]
    first, last = rng.normal(0, 50, (2, *stored.forces.shape))
    gravity = -9.81 * np.array([np.sin(np.deg2rad(10)), np.cos(np.deg2rad(10))])
    a0, a1 = (forces.sum(axis=1) / scenario.robot.mass + gravity for forces in (first, last))
    base = np.zeros_like(stored.base)
    base[1:, 3:5] = np.cumsum(h * (a0 + a1) / 2, axis=0)
    base[1:, :2] = np.cumsum(h * base[:-1, 3:5] + h**2 * (2 * a0 + a1) / 6, axis=0)
    base[:, 2], base[:, 5] = np.sin(3 * stored.times), 3 * np.cos(3 * stored.times)
    moved = replace(solution, task=task, trajectory=replace(stored, base=base, forces=first, end_forces=last))
    exact = scenario.model_copy(update={"transcription": Transcription(integrator="momentum", forces="linear")})
    scene, straight = scene_of(moved, exact), scene_of(moved, scenario)
    assert scene.slope == pytest.approx(np.deg2rad(10))
    for step in (0, 17, 38):
        t = 0.3 * h[step]
        expected = base[step, :2] + base[step, 3:5] * t + a0[step] * t**2 / 2
        expected = expected + (a1[step] - a0[step]) * t**3 / (6 * h[step])
        time = float(stored.times[step] + t[0])
        pose = scene.at(time)
        np.testing.assert_allclose(pose.position[[0, 2]], expected, atol=1e-12)
        np.testing.assert_allclose(pose.forces[:, [0, 2]], 0.7 * first[step] + 0.3 * last[step], atol=1e-9)
        assert np.arctan2(pose.rotation[2, 0], pose.rotation[0, 0]) == pytest.approx(np.sin(3 * time), abs=1e-6)
        line = 0.7 * base[step, :2] + 0.3 * base[step + 1, :2]
        np.testing.assert_allclose(straight.at(time).position[[0, 2]], line, atol=1e-12)


def test_feet_stay_in_their_boxes_below_the_hips(trot, anymal) -> None:
    """Ties hips, rotation and feet together: in the base frame a foot is within the box around its default place."""
    scene = scene_of(trot, anymal)
    for time in scene.times[:-1]:
        pose = scene.at(float(time))
        offset = (pose.feet - pose.hips) @ pose.rotation - [0.0, 0.0, -scene.height]
        assert (np.abs(offset) <= scene.box + 1e-6).all()


def test_a_leg_stands_when_its_pattern_says_so_and_only_then_carries(trot, anymal) -> None:
    scene = scene_of(trot, anymal)
    seen = set()
    for time in np.linspace(0.001, 0.799, 40):
        pose = scene.at(float(time))
        seen.add(pose.standing)
        swinging = [leg for leg, standing in enumerate(pose.standing) if not standing]
        assert np.abs(pose.forces[swinging]).max(initial=0) == pytest.approx(0, abs=1e-6)
    assert seen == {(True,) * 4, (False, True, True, False), (True, False, False, True)}


def test_the_body_spans_the_hips(trot, anymal) -> None:
    scene = scene_of(trot, anymal)
    assert scene.body.shape == (8, 3)
    np.testing.assert_allclose(np.ptp(scene.body, axis=0)[:2], np.ptp(scene.hips, axis=0)[:2])
    np.testing.assert_array_equal(scene.body[0], scene.body.min(axis=0))
    np.testing.assert_array_equal(scene.body[7], scene.body.max(axis=0))


def test_rotations_and_cameras_are_rotations() -> None:
    for matrix in (rotation_of(np.array([0.3, -0.2, 0.5])), camera(0.45, 0.3), camera(-2.0, 1.2)):
        np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(matrix) == pytest.approx(1.0)
    x, y, z = np.eye(3)
    np.testing.assert_allclose(rotation_of(np.array([np.pi / 2, 0, 0])) @ x, y, atol=1e-12)
    np.testing.assert_allclose(rotation_of(np.array([0, np.pi / 2, 0])) @ x, -z, atol=1e-12)
    np.testing.assert_allclose(rotation_of(np.array([0, 0, np.pi / 2])) @ y, z, atol=1e-12)


def test_the_camera_looks_from_the_right_the_front_and_the_top() -> None:
    x, y, z = np.eye(3)
    side, front, top = camera(0, 0), camera(np.pi / 2, 0), camera(0, np.pi / 2)
    np.testing.assert_allclose([side @ x, side @ z, side @ -y], np.eye(3), atol=1e-12)
    np.testing.assert_allclose([front @ y, front @ z, front @ x], np.eye(3), atol=1e-12)
    np.testing.assert_allclose([top @ x, top @ y, top @ z], np.eye(3), atol=1e-12)


def test_numbers_that_are_not_finite_are_refused(trot, anymal) -> None:
    forces = trot.trajectory.forces.copy()
    forces[3, 1, 2] = np.nan
    broken = replace(trot, trajectory=replace(trot.trajectory, forces=forces))
    with pytest.raises(
        ValueError, match=r"speed 0\.3 m/s, cycle_duration 0\.8 s has numbers that are not finite in forces"
    ):
        scene_of(broken, anymal)
