"""Reach by inverse kinematics against a leg that can be solved on paper, and the box trap on ANYmal."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gaitflow.config.file import ConfigError
from gaitflow.urdf.chain import LegChain
from gaitflow.urdf.mechanism import Array
from gaitflow.urdf.reach import ANYMAL_REACH, REACHED, check_box, default_box, distance, longest_reach

Write = Callable[..., Path]


def default_feet(legs: list[LegChain]) -> Array:
    return np.array([leg.foot_at(leg.stance)[0] for leg in legs])


def test_reach_agrees_with_geometry(walker: list[LegChain], by_hand: Any) -> None:
    """The foot stays `offset` beside the abduction axis and within thigh + shank of the flexion axis."""
    rng, seen = np.random.default_rng(1), set()
    for target in by_hand.hip + rng.uniform(-0.6, 0.6, (40, 3)):
        x, y, z = target - by_hand.hip
        outside = y**2 + z**2 - by_hand.offset**2  # squared length of the leg across the abduction axis
        length = np.sqrt(x**2 + outside) if outside >= 0 else np.inf
        if abs(length - by_hand.thigh - by_hand.shank) < 5 * REACHED or abs(outside) < 1e-3:
            continue
        reachable = bool(length < by_hand.thigh + by_hand.shank)
        assert (distance(walker[0], target) < REACHED) == reachable, target
        seen.add(reachable)
    assert seen == {True, False}


def test_how_far_a_point_is(walker: list[LegChain], by_hand: Any) -> None:
    """Straight below the flexion joint nothing but length counts."""
    below = by_hand.hip + np.array([0, by_hand.offset, -(by_hand.thigh + by_hand.shank + 0.1)])
    assert distance(walker[0], below) == pytest.approx(0.1, abs=5e-3)


def test_joint_limits_count(write: Write, by_hand: Any) -> None:
    limit = 'lower="-1.2" upper="1.2" effort="50" velocity="10"'
    legs = by_hand.legs(write(by_hand.text(limit)))
    folded = by_hand.hip + np.array([0, by_hand.offset, -0.1])  # needs a knee at 2.7 rad
    assert distance(legs[0], folded) > 0.2


def test_longest_reach(walker: list[LegChain], write: Write, by_hand: Any) -> None:
    assert longest_reach(walker[0]) == pytest.approx(by_hand.thigh + by_hand.shank, abs=1e-6)
    bent = by_hand.text().replace('name="LF_KFE" type="revolute"', 'name="LF_KFE" type="revolute" id="1"')
    start = bent.index('name="LF_KFE"')
    bent = bent[:start] + bent[start:].replace('upper="3.2"', 'upper="-0.8"', 1)
    leg = by_hand.legs(write(bent, "bent.urdf"))[0]
    thigh, shank = by_hand.thigh, by_hand.shank
    expected = np.sqrt(thigh**2 + shank**2 + 2 * thigh * shank * np.cos(0.8))
    assert longest_reach(leg) == pytest.approx(expected, abs=1e-6)


def test_the_box_trap_on_anymal(anymal: list[LegChain]) -> None:
    """Measured: with (0.2, 0.1, 0.1) no full-body planner converged, with (0.16, 0.1, 0.04) they did."""
    feet = default_feet(anymal)
    check_box(anymal, feet, np.array([0.16, 0.1, 0.04]))
    with pytest.raises(ConfigError) as caught:
        check_box(anymal, feet, np.array([0.2, 0.1, 0.1]))
    said = str(caught.value)
    assert said.startswith("box 0.2 x 0.1 x 0.1 m: leg ")
    assert "H cannot reach its corner -x " in said and " -z, 0.6" in said, "a hind leg, backwards and down"
    assert "longest reach from there is 0.593 m" in said and "comes no nearer than 48 mm" in said


def test_what_is_out_of_reach_is_named(walker: list[LegChain]) -> None:
    feet = default_feet(walker)
    box = np.array([0.01, 0.01, 0.07])  # the legs have 61 mm left downwards
    with pytest.raises(ConfigError, match=r"corner [+-]x [+-]y -z, .* from .._HFE .*reach from there is 0\.500 m"):
        check_box(walker, feet, box)


def test_a_box_that_is_reached_but_for_its_middle_is_refused(walker: list[LegChain], by_hand: Any) -> None:
    """Around the abduction axis there is a hole of radius `offset` that corners of a box can straddle."""
    centre = np.array([by_hand.hip + np.array([0.1, 0, 0])])
    with pytest.raises(ConfigError, match=r"cannot reach its (centre|face)"):
        check_box(walker[:1], centre, np.array([0.05, 0.1, 0.1]))


def test_the_default_box_has_anymals_proportions(anymal: list[LegChain]) -> None:
    assert longest_reach(anymal[0]) == pytest.approx(ANYMAL_REACH, abs=5e-4)
    box, part = default_box(anymal, default_feet(anymal))
    np.testing.assert_array_equal(box, [0.16, 0.1, 0.04])
    assert part == 1


def test_the_default_box_shrinks_to_what_is_reached(walker: list[LegChain]) -> None:
    feet = default_feet(walker)
    box, part = default_box(walker, feet)
    assert 0 < part < 1
    full = np.array([0.16, 0.1, 0.04]) * 0.5 / ANYMAL_REACH
    assert (box <= full * part).all() and (box > full * part - 1e-3).all()
    np.testing.assert_allclose(box * 1e3, np.round(box * 1e3), atol=1e-9)
    check_box(walker, feet, box)
    with pytest.raises(ConfigError, match="cannot reach"):
        check_box(walker, feet, full * (part + 0.01))


def test_straight_legs_reach_no_box(write: Write, by_hand: Any) -> None:
    legs = by_hand.legs(write(by_hand.text()))
    straight = [LegChain(leg.mechanism, leg.name, leg.foot, leg.joints, np.zeros(12)) for leg in legs]
    with pytest.raises(ConfigError, match="bend the knees more with --pose"):
        default_box(straight, default_feet(straight))
