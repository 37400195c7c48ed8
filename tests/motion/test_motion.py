"""A motion against closed forms, its own derivatives, the plan's knots, and what the task commands."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from bodies import PLANAR, SPATIAL
from cyclic import cyclic, cyclic_scenario
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitflow.core.layout import GRAVITY
from gaitflow.core.rigid_body import Attitude, RigidBody
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.core.twist import displacements
from gaitflow.motion import Motion, State

ROWS = ("0110", "1100", "0111", "1001", "1010", "0001")


@st.composite
def cases(draw: st.DrawFn, accelerating: bool = True) -> tuple[dict[str, Any], Trajectory, Task, str]:
    """A scenario, a cycle that closes, its task and its contacts: plane or space, straight or turning, up a slope."""
    spatial = draw(st.booleans())
    data = cyclic_scenario(SPATIAL if spatial else PLANAR)
    axes = {"speed": draw(st.floats(-1.0, 2.0)), "cycle_duration": draw(st.floats(0.2, 1.5))}
    if accelerating:
        axes["acceleration"] = draw(st.sampled_from([0.0, 0.4, -0.3]))
    if spatial:
        axes["lateral_speed"] = draw(st.floats(-0.5, 0.5))
        axes["yaw_rate"] = draw(st.sampled_from([0.0, 0.7, -1.3]))
    if not axes.get("yaw_rate"):
        axes["slope"] = draw(st.floats(-20.0, 20.0))
    legs = len(data["robot"]["legs"])
    pattern = "/".join(draw(st.lists(st.sampled_from(ROWS), min_size=legs, max_size=legs)))
    task = Task.of(axes)
    return data, cyclic(data, task, pattern, draw(st.integers(0, 2**31))), task, pattern


apexes = st.sampled_from([0.05, 0.12, None])
seeds = st.integers(0, 2**31)


def away_from_knots(trajectory: Trajectory, seed: int, count: int = 40, cycles: int = 3) -> Array:
    """Times in some cycles before and after 0, none of them near a knot."""
    rng = np.random.default_rng(seed)
    step = rng.integers(0, len(trajectory.times) - 1, count)
    start, h = trajectory.times[step], np.diff(trajectory.times)[step]
    return start + rng.uniform(0.1, 0.9, count) * h + rng.integers(-cycles, cycles + 1, count) * trajectory.times[-1]


def rotations(quaternions: Array) -> Array:
    """Matrices [n, 3, 3] of quaternions (w, x, y, z) [n, 4]."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


@given(cases(), st.sampled_from([0.05, None]))
@settings(max_examples=60)
def test_knots_are_the_plans(case: tuple[dict[str, Any], Trajectory, Task, str], apex: float | None) -> None:
    data, trajectory, task, pattern = case
    motion = Motion.of(data, trajectory, task, pattern, swing_apex=apex)
    body = RigidBody.of(data["robot"], task)
    seen = motion.sample(trajectory.times[:-1])
    position, angles, velocity, omega = (each[:-1] for each in body.split(trajectory.base))
    np.testing.assert_allclose(seen.position, position, atol=1e-10)
    np.testing.assert_allclose(seen.velocity, velocity, atol=1e-10)
    np.testing.assert_allclose(seen.angular_velocity, omega, atol=1e-10)
    np.testing.assert_allclose(seen.forces, trajectory.forces, atol=1e-9)
    stance = np.repeat([[digit == "1" for digit in row] for row in pattern.split("/")], 3, axis=1).T
    np.testing.assert_array_equal(seen.contact, stance)
    if apex is None:
        np.testing.assert_allclose(seen.feet, trajectory.feet[:-1], atol=1e-10)
    np.testing.assert_allclose(seen.feet[stance], trajectory.feet[:-1][stance], atol=1e-10)
    if body.dimension == 3:
        expected = np.stack([Attitude(angles).into_world(np.broadcast_to(e, angles.shape)) for e in np.eye(3)], axis=-1)
        np.testing.assert_allclose(rotations(seen.orientation), expected, atol=1e-12)


@given(cases(), seeds, apexes)
@settings(max_examples=60)
def test_rates_are_derivatives(case: tuple[dict[str, Any], Trajectory, Task, str], seed: int, apex: float) -> None:
    data, trajectory, task, pattern = case
    motion = Motion.of(data, trajectory, task, pattern, swing_apex=apex)
    times = away_from_knots(trajectory, seed)
    step = 1e-3 * float(np.diff(trajectory.times).min())
    if apex is not None:  # the top of a swing is a place like the knots
        waits = motion.sample(times).until_touchdown
        times = times[(waits > step).all(axis=1)]
    before, at, after = (motion.sample(times + shift) for shift in (-step, 0.0, step))
    for value, rate in (
        ("position", "velocity"),
        ("velocity", "acceleration"),
        ("feet", "foot_velocities"),
        ("foot_velocities", "foot_accelerations"),
    ):
        if (value, apex) == ("foot_velocities", None):
            continue  # straight lines
        slope = (getattr(after, value) - getattr(before, value)) / (2 * step)
        expected = getattr(at, rate)
        np.testing.assert_allclose(slope, expected, atol=1e-3 * max(1.0, np.abs(expected).max()), err_msg=value)
    turned = (rotations(after.orientation) - rotations(before.orientation)) / (2 * step)
    spinning = np.swapaxes(rotations(at.orientation), 1, 2) @ turned  # of a skew matrix
    found = np.stack([spinning[:, 2, 1], spinning[:, 0, 2], spinning[:, 1, 0]], axis=-1)
    expected = at.angular_velocity if motion.dimension == 3 else at.angular_velocity * [0.0, -1.0, 0.0]
    np.testing.assert_allclose(found, expected, atol=1e-3 * max(1.0, np.abs(expected).max()))


@given(cases(), apexes)
@settings(max_examples=60)
def test_nothing_jumps(case: tuple[dict[str, Any], Trajectory, Task, str], apex: float | None) -> None:
    """At knots, at the borders of cycles, at lift-off, at the top of a swing and at touchdown; forces do."""
    data, trajectory, task, pattern = case
    motion = Motion.of(data, trajectory, task, pattern, swing_apex=apex)
    knots = np.concatenate([trajectory.times[:-1] + n * task.cycle_duration for n in (-2, -1, 0, 1, 2)])
    stances = [stance for leg in motion.leg_names for stance in motion.phases(leg, 2)]
    borders = np.concatenate([knots, [stance.start for stance in stances], [stance.end for stance in stances]])
    before, after = motion.sample(borders - 1e-11), motion.sample(borders + 1e-11)
    names = ["position", "velocity", "orientation", "angular_velocity", "feet"]
    if apex is not None:
        names += ["foot_velocities", "foot_accelerations"]
    for name in names:
        one, other = getattr(before, name), getattr(after, name)
        np.testing.assert_allclose(one, other, atol=1e-5 * max(1.0, np.abs(one).max()), err_msg=name)
    if apex is not None:
        edges = motion.sample(np.array([stance.end for stance in stances]))
        assert np.abs(edges.foot_velocities[edges.contact]).max(initial=0.0) == 0.0


@given(cases(), seeds)
@settings(max_examples=40)
def test_forces_move_the_body(case: tuple[dict[str, Any], Trajectory, Task, str], seed: int) -> None:
    """m a = sum of forces + m g at any time, and the impulse over whole cycles is the gain of momentum."""
    data, trajectory, task, pattern = case
    motion, body = Motion.of(data, trajectory, task, pattern), RigidBody.of(data["robot"], task)
    seen = motion.sample(away_from_knots(trajectory, seed))
    np.testing.assert_allclose(seen.acceleration, body.acceleration(seen.forces), atol=1e-9)
    every = [trajectory.times[:-1] + n * task.cycle_duration for n in range(-1, 3)]
    knots = np.append(np.concatenate(every), 3 * task.cycle_duration)
    h = np.diff(knots)
    ends = motion.sample(np.concatenate([knots[:-1] + 1e-7 * h, knots[1:] - 1e-7 * h]))
    first, last = np.split(ends.forces.sum(axis=1), 2)
    impulse = (h[:, None] * (first + last) / 2).sum(axis=0) + body.mass * body.gravity * h.sum()
    moved = motion.sample([knots[0], knots[-1]]).velocity
    np.testing.assert_allclose(impulse, body.mass * (moved[1] - moved[0]), rtol=1e-6, atol=1e-3)


@given(cases(accelerating=False), seeds, st.integers(-50, 50), apexes)
@settings(max_examples=40)
def test_cycles_repeat_moved_by_the_twist(
    case: tuple[dict[str, Any], Trajectory, Task, str], seed: int, number: int, apex: float | None
) -> None:
    data, trajectory, task, pattern = case
    motion = Motion.of(data, trajectory, task, pattern, swing_apex=apex)
    times, later = away_from_knots(trajectory, seed, cycles=1), number * task.cycle_duration
    here, there = motion.sample(times), motion.sample(times + later)
    angle, d = task["yaw_rate"] * later, motion.dimension
    turn, shift = np.eye(d), np.zeros(d)
    if d == 3:
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    shift[: d - 1] = displacements(task, np.array(later))[: d - 1]
    for name in ("position", "feet"):
        np.testing.assert_allclose(getattr(there, name), getattr(here, name) @ turn.T + shift, atol=1e-9)
    for name in ("velocity", "acceleration", "foot_velocities", "foot_accelerations", "forces"):
        scale = np.abs(getattr(here, name)).max()
        np.testing.assert_allclose(getattr(there, name), getattr(here, name) @ turn.T, atol=1e-8 * max(1.0, scale))
    np.testing.assert_allclose(there.angular_velocity, here.angular_velocity, atol=1e-9)
    np.testing.assert_allclose(there.until_touchdown, here.until_touchdown, atol=1e-9)
    np.testing.assert_array_equal(there.contact, here.contact)


@given(cases(), seeds, st.integers(1, 4))
@settings(max_examples=40)
def test_phases_are_what_the_states_show(
    case: tuple[dict[str, Any], Trajectory, Task, str], seed: int, cycles: int
) -> None:
    data, trajectory, task, pattern = case
    motion = Motion.of(data, trajectory, task, pattern)
    times = np.sort(np.random.default_rng(seed).uniform(0, cycles * task.cycle_duration, 30))
    seen = motion.sample(times)
    for leg, name in enumerate(motion.leg_names):
        stances = motion.phases(name, cycles)
        assert all(a.end < b.start for a, b in pairwise(stances))
        assert all(stance.start < cycles * task.cycle_duration and stance.end > 0 for stance in stances)
        following = motion.phases(leg, cycles + 2)
        for i, t in enumerate(times):
            own = [stance for stance in stances if stance.start <= t < stance.end]
            assert bool(seen.contact[i, leg]) == (len(own) == 1)
            if own:
                np.testing.assert_allclose(seen.feet[i, leg], own[0].foothold, atol=1e-12)
                assert own[0].foothold[-1] == 0.0
            touchdown = min(stance.start for stance in following if stance.start > t)
            assert seen.until_touchdown[i, leg] == pytest.approx(touchdown - t, abs=1e-9)


@given(cases(), st.floats(0.01, 0.3))
@settings(max_examples=30)
def test_swings_rise_to_their_apex_at_half_time(
    case: tuple[dict[str, Any], Trajectory, Task, str], apex: float
) -> None:
    data, trajectory, task, pattern = case
    motion = Motion.of(data, trajectory, task, pattern, swing_apex=apex)
    for leg in range(len(motion.leg_names)):
        stances = motion.phases(leg, 3)
        for one, other in pairwise(stances):
            top = motion.at((one.end + other.start) / 2)
            np.testing.assert_allclose(top.feet[leg, :-1], (one.foothold + other.foothold)[:-1] / 2, atol=1e-9)
            assert top.feet[leg, -1] == pytest.approx(apex, abs=1e-9)
            assert top.foot_velocities[leg, -1] == pytest.approx(0.0, abs=1e-6)
            curve = motion.sample(np.linspace(one.end + 1e-9, other.start - 1e-9, 50))
            assert curve.feet[:, leg, -1].min() > -1e-12 and curve.feet[:, leg, -1].max() <= apex + 1e-12
            assert not curve.contact[:, leg].any()


def glide(task: Task) -> tuple[dict[str, Any], Trajectory]:
    """A level body at the commanded velocity on four standing feet; no step is taken."""
    data = cyclic_scenario(SPATIAL)
    trajectory = cyclic(data, task, "1111/1111/1111/1111", 0)
    times, base, forces = trajectory.times, np.zeros_like(trajectory.base), np.zeros_like(trajectory.forces)
    base[:, :2], base[:, 2] = displacements(task, times), 0.5
    base[:, 6] = task.speed
    forces[..., 2] = data["robot"]["mass"] * GRAVITY / 4
    return data, replace(trajectory, base=base, forces=forces, end_forces=forces)


@pytest.mark.parametrize("time", [-7.3, -0.6, 0.0, 0.25, 0.6, 1e6 + 0.1])
def test_a_glide(time: float) -> None:
    task = Task.of({"speed": 0.8, "cycle_duration": 0.6})
    data, trajectory = glide(task)
    state = Motion.of(data, trajectory, task, "1111/1111/1111/1111").at(time)
    np.testing.assert_allclose(state.position, [0.8 * time, 0, 0.5], atol=1e-9)
    np.testing.assert_allclose(state.velocity, [0.8, 0, 0], atol=1e-12)
    np.testing.assert_allclose(state.acceleration, 0, atol=1e-12)
    np.testing.assert_allclose(state.orientation, [1, 0, 0, 0], atol=1e-15)
    assert state.contact.all() and np.isinf(state.until_touchdown).all() and not state.foot_velocities.any()


@pytest.mark.parametrize("number", [-3, 0, 1, 7])
def test_a_body_that_speeds_up_follows_a_parabola(number: int) -> None:
    """After n cycles it is n a T faster and v n T + a T^2 n (n - 1) / 2 further; feet keep up with it."""
    task = Task.of({"speed": 0.5, "cycle_duration": 0.6, "acceleration": 0.4})
    data = cyclic_scenario(PLANAR)
    motion = Motion.of(data, cyclic(data, task, "0110/1100", 3), task, "0110/1100")
    first, then = motion.at(0.1), motion.at(0.1 + number * 0.6)
    gain = 0.4 * 0.6 * number
    assert then.velocity[0] - first.velocity[0] == pytest.approx(gain)
    way = 0.5 * 0.6 * number + 0.4 * 0.6**2 * number * (number - 1) / 2 + gain * 0.1
    assert then.position[0] - first.position[0] == pytest.approx(way)
    np.testing.assert_allclose(then.velocity[1], first.velocity[1], atol=1e-12)
    for leg in (0, 1):
        stances = motion.phases(leg, 6)
        ahead = [float(s.foothold[0] - motion.at((s.start + s.end) / 2).position[0]) for s in stances if s.start >= 1.2]
        assert len(ahead) > 3
        np.testing.assert_allclose(ahead, ahead[0], atol=1e-9)


@given(cases(), seeds)
@settings(max_examples=30)
def test_the_base_link_goes_with_the_centre_of_mass(
    case: tuple[dict[str, Any], Trajectory, Task, str], seed: int
) -> None:
    data, trajectory, task, pattern = case
    if data["robot"]["dimension"] == 2:
        return
    offset = np.array([0.03, -0.01, 0.05])
    feet = [{"leg": leg["name"], "link": "foot", "contact_point": [0, 0, 0]} for leg in data["robot"]["legs"]]
    frames = {"base_link": "base", "com_in_base": offset.tolist(), "feet": feet}
    known = data | {"robot": data["robot"] | {"frames": frames}}
    centre = Motion.of(known, trajectory, task, pattern)
    base = Motion.of(known, trajectory, task, pattern, point="base")
    times = away_from_knots(trajectory, seed)
    one, other = centre.sample(times), base.sample(times)
    np.testing.assert_allclose(one.position, other.position + rotations(one.orientation) @ offset, atol=1e-12)
    step = 1e-4 * float(np.diff(trajectory.times).min())
    before, after = base.sample(times - step), base.sample(times + step)
    for value, rate in (("position", "velocity"), ("velocity", "acceleration")):
        slope = (getattr(after, value) - getattr(before, value)) / (2 * step)
        expected = getattr(other, rate)
        np.testing.assert_allclose(slope, expected, atol=1e-4 * max(1.0, np.abs(expected).max()))
    for name in ("orientation", "angular_velocity", "feet", "forces"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.fixture
def made() -> tuple[dict[str, Any], Trajectory, Task, str]:
    data, task = cyclic_scenario(SPATIAL), Task.of({"speed": 0.5, "cycle_duration": 0.6})
    pattern = "0110/1100/0000/0011"
    return data, cyclic(data, task, pattern, 5), task, pattern


@pytest.fixture
def motion(made: tuple[dict[str, Any], Trajectory, Task, str]) -> Motion:
    return Motion.of(*made)


def test_shapes(motion: Motion) -> None:
    many, one, none = motion.sample(np.linspace(-1, 1, 7)), motion.at(0.1), motion.sample([])
    shapes = {
        "time": (), "position": (3,), "velocity": (3,), "acceleration": (3,), "orientation": (4,),
        "angular_velocity": (3,), "contact": (4,), "feet": (4, 3), "foot_velocities": (4, 3),
        "foot_accelerations": (4, 3), "forces": (4, 3), "until_touchdown": (4,),
    }  # fmt: skip
    assert set(shapes) == {field.name for field in fields(State)}
    for name, shape in shapes.items():
        assert np.shape(getattr(one, name)) == shape
        assert getattr(many, name).shape == (7, *shape)
        assert getattr(none, name).shape == (0, *shape)
    for i, time in enumerate(np.linspace(-1, 1, 7)):
        for name in shapes:
            np.testing.assert_allclose(getattr(many, name)[i], getattr(motion.at(time), name), atol=1e-11)


def test_a_leg_that_never_stands_follows_the_plan(
    made: tuple[dict[str, Any], Trajectory, Task, str], motion: Motion
) -> None:
    trajectory = made[1]
    assert motion.phases("LH", 5) == []
    seen = motion.sample(trajectory.times)
    np.testing.assert_allclose(seen.feet[:, 2], trajectory.feet[:, 2], atol=1e-12)
    np.testing.assert_allclose(seen.foot_velocities[:-1, 2], trajectory.foot_velocities[:, 2], atol=1e-9)
    assert np.isinf(seen.until_touchdown[:, 2]).all() and not seen.contact[:, 2].any()


def test_a_leg_that_never_swings_has_one_stance_without_end() -> None:
    task = Task.of({"speed": 0.0, "cycle_duration": 0.6})
    data, trajectory = glide(task)
    motion = Motion.of(data, trajectory, task, "1111/1111/1111/1111")
    (stance,) = motion.phases("RF", 3)
    assert (stance.start, stance.end) == (-np.inf, np.inf)
    np.testing.assert_allclose(stance.foothold, trajectory.feet[0, 1], atol=1e-15)
    np.testing.assert_allclose(motion.at(12.3).feet, trajectory.feet[0], atol=1e-12)


@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf, "1", None, True])
def test_times_that_are_none(motion: Motion, time: Any) -> None:
    with pytest.raises(ValueError, match=r"time = .*: must be a finite number of seconds"):
        motion.at(time)


@pytest.mark.parametrize("times", [[0.1, np.nan], [[0.1]], 0.1, ["a"], [None]])
def test_lists_of_times_that_are_none(motion: Motion, times: Any) -> None:
    with pytest.raises(ValueError, match=r"times.*(list of numbers|finite number of seconds)"):
        motion.sample(times)


@pytest.mark.parametrize("leg", ["XX", 4, -1, True, None, 1.0])
def test_legs_that_are_none(motion: Motion, leg: Any) -> None:
    with pytest.raises(ValueError, match=r"leg = .*: the legs are 0 LF, 1 RF, 2 LH, 3 RH"):
        motion.phases(leg)


@pytest.mark.parametrize("cycles", [0, -1, 1.5, True, None])
def test_numbers_of_cycles_that_are_none(motion: Motion, cycles: Any) -> None:
    with pytest.raises(ValueError, match=r"cycles = .*: must be a number of cycles, 1 or more"):
        motion.phases("LF", cycles)


@pytest.mark.parametrize("apex", [0.0, -0.1, np.nan, np.inf, "high", True])
def test_apexes_that_are_none(made: tuple[dict[str, Any], Trajectory, Task, str], apex: Any) -> None:
    with pytest.raises(ValueError, match=r"swing_apex = .*: must be a height above 0 m, or None"):
        Motion.of(*made, swing_apex=apex)


def test_points_that_are_none(made: tuple[dict[str, Any], Trajectory, Task, str]) -> None:
    with pytest.raises(ValueError, match="point = 'hip': must be"):
        Motion.of(*made, point="hip")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="the map made-by-hand does not know its robot's base link: import"):
        Motion.of(*made, point="base")


def test_knots_that_do_not_rise_are_no_motion(made: tuple[dict[str, Any], Trajectory, Task, str]) -> None:
    data, trajectory, task, pattern = made
    with pytest.raises(ValueError, match=r"do not rise from 0 to 0\.6 s"):
        Motion.of(data, replace(trajectory, times=2 * trajectory.times), task, pattern)
