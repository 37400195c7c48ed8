"""Force and speed of a foot from joint limits, against levers worked out by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.limits import max_foot_speed, max_vertical_force

Write = Callable[..., Path]


def test_force_is_effort_over_lever(walker: list[LegChain], by_hand: Any) -> None:
    """The foot is straight below the flexion joint: no lever there; abduction has `offset`, the knee more."""
    levers = {"HAA": by_hand.offset, "KFE": by_hand.thigh * np.sin(0.5)}
    assert max_vertical_force(walker) == pytest.approx(50 / max(levers.values()))


def test_anymals_force_and_speed(anymal: list[LegChain]) -> None:
    assert max_vertical_force(anymal) == pytest.approx(422, abs=0.5)
    assert max_foot_speed(anymal) == pytest.approx(2.54, abs=0.01)


def test_every_joint_holds_at_that_force_and_one_is_at_its_limit(anymal: list[LegChain]) -> None:
    force = max_vertical_force(anymal)
    torques = np.array([leg.foot_at(leg.stance)[1].T @ [0, 0, force] for leg in anymal])
    assert np.abs(torques).max() == pytest.approx(80)


def test_every_foot_moves_at_that_speed_and_one_joint_is_at_its_limit(anymal: list[LegChain]) -> None:
    speed = max_foot_speed(anymal)
    rates = np.array([np.linalg.solve(leg.foot_at(leg.stance)[1], speed * np.eye(3)) for leg in anymal])
    assert np.abs(rates).max() == pytest.approx(15)


@pytest.mark.parametrize(
    ("limit", "compute", "said"),
    [
        ('effort="0" velocity="10"', max_vertical_force, "no effort limit of LF_HAA, LF_KFE: give --max-force"),
        ('effort="1000" velocity="10"', max_vertical_force, "times the robot's weight: placeholders"),
        ('effort="50" velocity="0"', max_foot_speed, "no velocity limit of LF_HAA, LF_HFE, LF_KFE: give --max-foot-sp"),
        ('effort="50" velocity="1000"', max_foot_speed, "joint LF_HAA has a velocity limit of 1000 rad/s: a placeh"),
    ],
)
def test_limits_that_say_nothing(
    write: Write, by_hand: Any, limit: str, compute: Callable[[list[LegChain]], float], said: str
) -> None:
    legs = by_hand.legs(write(by_hand.text(f'lower="-3.2" upper="3.2" {limit}')))
    with pytest.raises(ConfigError, match=said):
        compute(legs)


def test_a_straight_leg_moves_only_on_a_sphere(walker: list[LegChain]) -> None:
    straight = [LegChain(leg.mechanism, leg.name, leg.foot, leg.joints, np.zeros(12)) for leg in walker]
    with pytest.raises(ConfigError, match=r"leg LF: its foot cannot move along [yz] in this pose"):
        max_foot_speed(straight)
