"""A robot that is commanded in every direction gets motions that go there, and mirrored ones for mirrored commands."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from golden_plans import published

from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.runtime import GaitMap, Plan

COMMANDS = {  # speed [m/s], lateral_speed [m/s], yaw_rate [rad/s]
    "forwards": (1.0, 0.0, 0.0),
    "backwards": (-0.4, 0.0, 0.0),
    "sideways": (0.0, 0.3, 0.0),
    "turning on the spot": (0.0, 0.0, 0.7),
    "a curve": (0.8, 0.0, 0.5),
    "backwards in a curve, across": (-0.3, -0.2, 0.4),
    "standing still": (0.0, 0.0, 0.0),
}
CYCLE = 0.6  # s
MIRROR = (1, 0, 3, 2)  # LF, RF, LH, RH with left and right swapped


@pytest.fixture(scope="module")
def gait_map() -> GaitMap:
    return GaitMap.load(published()["anymal-omni"])


def planned(gait_map: GaitMap, speed: float, lateral_speed: float, yaw_rate: float) -> Plan:
    return gait_map.plan(speed=speed, lateral_speed=lateral_speed, yaw_rate=yaw_rate, cycle_duration=CYCLE)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_command_is_followed(gait_map: GaitMap, command: tuple[float, float, float]) -> None:
    plan = planned(gait_map, *command)
    assert plan.in_domain and plan.feasible and plan.path != "fallback"
    speed, lateral_speed, yaw_rate = command
    moved = plan.base[-1] - plan.base[0]
    assert moved[3] == pytest.approx(yaw_rate * CYCLE, abs=1e-6)
    turn = yaw_rate * CYCLE
    mean = (cmath.exp(1j * turn) - 1) / (1j * turn) if turn else 1.0
    first = complex(*plan.base[0, :2])
    last = cmath.exp(1j * turn) * first + complex(speed, lateral_speed) * CYCLE * mean
    np.testing.assert_allclose(plan.base[-1, :2], [last.real, last.imag], atol=1e-6)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_the_mirrored_command_costs_the_same(gait_map: GaitMap, command: tuple[float, float, float]) -> None:
    speed, lateral_speed, yaw_rate = command
    one, other = planned(gait_map, *command), planned(gait_map, speed, -lateral_speed, -yaw_rate)
    assert other.feasible and other.cost == pytest.approx(one.cost, rel=1e-3)


def test_straight_ahead_a_gait_and_its_mirror_image_do_not_take_turns(gait_map: GaitMap) -> None:
    """They cost the same there, and rounding must not say which one is taken."""
    speeds = np.linspace(-0.5, 1.4, 60)
    named = gait_map.select_many(speed=speeds, lateral_speed=0.0, yaw_rate=0.0, cycle_duration=CYCLE).gaits
    keys = {gait.name: gait.key for gait in gait_map.gaits}
    images = {name: gait_of(Pattern.from_text(key).mirrored(MIRROR)).text for name, key in keys.items()}
    taken = {keys[name] for name in named}
    assert not {key for name, key in keys.items() if key in taken and images[name] in taken - {key}}


def test_left_and_right_the_gaits_are_mirror_images(gait_map: GaitMap) -> None:
    """Of all random commands but the few at which an atlas that grew to both sides is not its own image."""
    turned = np.random.default_rng(0).uniform((-0.5, -0.4, -0.8, 0.4), (1.4, 0.4, 0.8, 0.8), (200, 4))
    names = ("speed", "lateral_speed", "yaw_rate", "cycle_duration")
    keys = {gait.name: gait.key for gait in gait_map.gaits}
    there, back = (
        [keys[name] for name in gait_map.select_many(**dict(zip(names, (turned * signs).T, strict=True))).gaits]
        for signs in ((1, 1, 1, 1), (1, -1, -1, 1))
    )
    images = [gait_of(Pattern.from_text(key).mirrored(MIRROR)).text for key in back]
    assert np.mean(np.array(images) == np.array(there)) > 0.95


def test_who_stands_still_steps_on_the_spot(gait_map: GaitMap) -> None:
    plan = planned(gait_map, 0.0, 0.0, 0.0)
    assert np.ptp(plan.base[:, :2], axis=0).max() < 0.05  # m
    assert np.ptp(plan.feet[..., :2], axis=0).max() < 0.05
