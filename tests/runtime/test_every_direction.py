"""A robot that is commanded in every direction gets motions that go there, and mirrored ones for mirrored commands."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from golden_plans import published

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


def test_who_stands_still_steps_on_the_spot(gait_map: GaitMap) -> None:
    plan = planned(gait_map, 0.0, 0.0, 0.0)
    assert np.ptp(plan.base[:, :2], axis=0).max() < 0.05  # m
    assert np.ptp(plan.feet[..., :2], axis=0).max() < 0.05
