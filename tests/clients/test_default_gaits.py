"""Hand-made gaits against what Raibert, the duty factor and the weight say they are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from bodies import PLANAR, SPATIAL
from cyclic import cyclic_scenario

from gaitflow.clients.default_gaits import Kind, default_motion
from gaitflow.core.gaits import Pattern
from gaitflow.core.layout import GRAVITY
from gaitflow.core.names import gait_kind
from gaitflow.core.task import Task

LEGS = ("LF", "RF", "LH", "RH")
# Later than the first leg, as parts of the cycle.
LANDINGS = {
    "trot": (0.0, 0.5, 0.5, 0.0),
    "pace": (0.0, 0.5, 0.0, 0.5),
    "bound": (0.5, 0.5, 0.0, 0.0),
    "walk": (0.25, 0.75, 0.0, 0.5),
}
CASES = [
    *((kind, duty) for kind in ("trot", "pace", "bound") for duty in (0.35, 0.5, 0.62)),
    *(("walk", duty) for duty in (0.25, 0.5, 0.75)),
]
TASKS = [
    Task.of({"speed": 0.6, "cycle_duration": 0.5}),
    Task.of({"speed": 0.4, "lateral_speed": -0.2, "yaw_rate": 0.8, "cycle_duration": 0.7, "payload": 4.0}),
    Task.of({"speed": 0.5, "cycle_duration": 0.6, "slope": -12.0}),
]


@pytest.fixture
def scenario() -> dict[str, Any]:
    return cyclic_scenario(SPATIAL)


@pytest.mark.parametrize("task", TASKS, ids=["straight", "turning", "downhill"])
@pytest.mark.parametrize(("kind", "duty"), CASES)
class TestGait:
    def test_each_foot_stands_for_the_duty_at_the_kinds_time(
        self, scenario: dict[str, Any], kind: Kind, duty: float, task: Task
    ) -> None:
        motion, period = default_motion(scenario, kind, task, duty, point="com"), task.cycle_duration
        for leg, later in zip(LEGS, LANDINGS[kind], strict=True):
            stance = next(each for each in motion.phases(leg, 3) if each.start > -1e-9)
            assert stance.end - stance.start == pytest.approx(duty * period)
            assert stance.start == pytest.approx(later * period)

    def test_footholds_are_under_the_default_place_at_the_middle_of_the_stance(
        self, scenario: dict[str, Any], kind: Kind, duty: float, task: Task
    ) -> None:
        motion = default_motion(scenario, kind, task, duty, point="com")
        # In a turn, or in flight on a slope, no force keeps the body where the command has it within the cycle.
        off = 5e-3 if task["yaw_rate"] or task["slope"] else 1e-9
        for leg, default in zip(LEGS, (each["default_foot"] for each in scenario["robot"]["legs"]), strict=True):
            for stance in motion.phases(leg, 3):
                middle = motion.at((stance.start + stance.end) / 2)
                offset = stance.foothold[:2] - middle.position[:2]
                # The quaternion of a turn about z is (cos, 0, 0, sin) of half the angle.
                angle = 2 * math.atan2(middle.orientation[3], middle.orientation[0])
                turned = complex(*offset) * np.exp(-1j * angle)
                np.testing.assert_allclose([turned.real, turned.imag], default[:2], atol=off)
                assert stance.foothold[2] == 0.0

    def test_forces_carry_the_weight_and_only_where_feet_stand(
        self, scenario: dict[str, Any], kind: Kind, duty: float, task: Task
    ) -> None:
        motion = default_motion(scenario, kind, task, duty, point="com")
        made, mass = motion.trajectory, scenario["robot"]["mass"] + task["payload"]
        mean = np.diff(made.times) @ made.forces.sum(axis=1) / task.cycle_duration
        slope = math.radians(task["slope"])
        np.testing.assert_allclose(mean, mass * GRAVITY * np.array([math.sin(slope), 0, math.cos(slope)]), atol=1e-9)
        np.testing.assert_array_equal(made.forces, made.end_forces)
        times = np.linspace(-task.cycle_duration, task.cycle_duration, 83)
        seen = motion.sample(times)
        assert ((seen.forces[..., 2] > 0) == seen.contact).all()

    def test_the_body_is_level_and_each_cycle_is_the_one_before_moved_on(
        self, scenario: dict[str, Any], kind: Kind, duty: float, task: Task
    ) -> None:
        motion, period = default_motion(scenario, kind, task, duty, point="com"), task.cycle_duration
        times = np.linspace(0, 0.99 * period, 23)
        now, then = motion.sample(times), motion.sample(times + 2 * period)
        np.testing.assert_allclose(now.orientation[:, 1:3], 0, atol=1e-12)
        np.testing.assert_allclose(now.position[:, 2], then.position[:, 2], atol=1e-9)
        np.testing.assert_allclose(now.feet[..., 2], then.feet[..., 2], atol=1e-9)
        np.testing.assert_array_equal(now.contact, then.contact)
        reach = np.linalg.norm(now.feet - now.position[:, None], axis=-1)
        np.testing.assert_allclose(reach, np.linalg.norm(then.feet - then.position[:, None], axis=-1), atol=1e-9)
        assert now.position[0, 2] == pytest.approx(0.45)


@pytest.mark.parametrize(("kind", "duty", "name"), [
    ("trot", 0.5, "trot"), ("trot", 0.6, "walking trot"), ("trot", 0.4, "running trot"), ("pace", 0.5, "pace"),
    ("bound", 0.4, "bound"), ("bound", 0.6, "walking bound"), ("walk", 0.75, "four-beat walk"),
])  # fmt: skip
def test_the_pattern_is_the_gait_of_that_name(scenario: dict[str, Any], kind: Kind, duty: float, name: str) -> None:
    motion = default_motion(scenario, kind, TASKS[0], duty, point="com")
    assert gait_kind(Pattern.from_text(motion.pattern), motion.leg_names) == name


def test_legs_are_told_apart_by_their_names_and_not_their_order(scenario: dict[str, Any]) -> None:
    order = [3, 0, 2, 1]
    legs = scenario["robot"]["legs"]
    other = scenario | {"robot": scenario["robot"] | {"legs": [legs[i] for i in order]}}
    here = default_motion(scenario, "walk", TASKS[1], 0.75, point="com").sample(np.linspace(0, 1, 17))
    there = default_motion(other, "walk", TASKS[1], 0.75, point="com").sample(np.linspace(0, 1, 17))
    np.testing.assert_allclose(there.feet, here.feet[:, order], atol=1e-12)
    np.testing.assert_allclose(there.forces, here.forces[:, order], atol=1e-12)


def test_knots_lie_on_the_motion(scenario: dict[str, Any]) -> None:
    motion = default_motion(scenario, "bound", TASKS[0], 0.3, point="com")
    seen = motion.sample(motion.trajectory.times)
    np.testing.assert_allclose(motion.trajectory.base[:, :3], seen.position, atol=1e-12)
    np.testing.assert_allclose(motion.trajectory.base[:, 6:9], seen.velocity, atol=1e-12)
    np.testing.assert_allclose(motion.trajectory.feet, seen.feet, atol=1e-12)
    assert np.ptp(seen.position[:, 2]) > 0.01  # it flies


@pytest.mark.parametrize(("kind", "duty", "said"), [
    ("amble", 0.5, "trot, walk, pace, bound"), ("trot", 0.0, "between 0 and 1"), ("trot", 1.0, "between 0 and 1"),
    ("trot", math.nan, "between 0 and 1"), ("walk", 0.6, "0.25, 0.5, 0.75"), ("walk", 0.1, "0.25, 0.5, 0.75"),
])  # fmt: skip
def test_what_cannot_be_says_what_can(scenario: dict[str, Any], kind: Any, duty: float, said: str) -> None:
    with pytest.raises(ValueError, match=said) as error:
        default_motion(scenario, kind, TASKS[0], duty)
    assert "\n" not in str(error.value)


def test_other_robots_and_tasks_are_refused(scenario: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="quadruped"):
        default_motion(cyclic_scenario(PLANAR), "trot", TASKS[0], 0.5)
    with pytest.raises(ValueError, match="keeps its speed"):
        default_motion(scenario, "trot", TASKS[0].replaced(acceleration=0.3), 0.5)
    eight = scenario | {"transcription": scenario["transcription"] | {"phases": 8}}
    with pytest.raises(ValueError, match="phases = 8"):
        default_motion(eight, "trot", TASKS[0], 0.5)
