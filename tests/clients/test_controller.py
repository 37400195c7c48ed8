from __future__ import annotations

import numpy as np
import pytest
from walking_robots import planned

from gaitflow.clients.body_target import rotation_between
from gaitflow.clients.reference import Ahead, lifted_at, stance_durations
from gaitflow.clients.rotation import rotation_of
from gaitflow.clients.swing_feet import SwingFeet
from gaitflow.motion import Motion


def test_reference_is_the_motion_from_one_piece_to_the_next() -> None:
    motion = planned("anymal", 0.6, 0.6)
    ahead = Ahead(motion, 0.002)
    for step in (0, 1, 9, 10, 11, 500, 3):
        state, expected = ahead.at(0.002 * step).state, motion.at(0.002 * step)
        assert state.position == pytest.approx(expected.position, abs=1e-12)
        assert (state.contact == expected.contact).all()


def test_feet_in_the_air_lifted_off_at_the_end_of_their_stance() -> None:
    motion = planned("anymal", 0.6, 0.6)
    stance = motion.phases("LF")[0]
    swinging = stance.end + 0.05
    contact = motion.at(swinging).contact
    assert not contact[0]
    assert lifted_at(motion, swinging, contact)[0] == pytest.approx(stance.end, abs=0.01)


def test_stances_last_as_long_as_the_plan_says() -> None:
    motion = planned("anymal", 0.6, 0.6)
    expected = [motion.phases(leg)[0].end - motion.phases(leg)[0].start for leg in motion.leg_names]
    for time in (0.0, 0.25, 17.0):
        assert stance_durations(motion, time, ahead=6.0) == pytest.approx(expected, rel=0.06)


def feet_at(motion: Motion, time: float, touching: list[bool], shift: float = 0.0, start: float | None = None):
    feet = SwingFeet(np.zeros((4, 3)), motion, time if start is None else start)
    state = motion.at(time)
    return state, feet.targets(time, state, np.array(touching), state.feet, np.tile([shift, 0.0, 0.0], (4, 1)), 0.0)


def test_foot_that_touches_late_in_its_swing_stands() -> None:
    motion = planned("anymal", 0.6, 0.6)  # LF swings from 0 to 0.144 s
    for time, stands in ((0.03, False), (0.12, True)):
        state, found = feet_at(motion, time, [True, True, True, False])
        assert not state.contact[0]
        assert found.standing[0] == stands


def test_foot_that_misses_the_ground_goes_on_down() -> None:
    motion = planned("anymal", 0.6, 0.6)
    feet = SwingFeet(np.zeros((4, 3)), motion, 0.1)
    state = motion.at(0.2)
    found = feet.targets(0.2, state, np.array([False, True, True, True]), state.feet, np.zeros((4, 3)), 0.0)
    assert not found.standing[0] and found.standing[1:].all()
    assert found.velocities[0, 2] < -0.1


def test_footholds_to_come_are_moved_and_those_that_stand_are_not() -> None:
    motion = planned("anymal", 0.6, 0.6)
    state, found = feet_at(motion, 0.1, [False, True, True, False], shift=0.05)
    moved = (found.positions - state.feet)[:, 0]
    assert 0.02 < moved[0] <= 0.05
    assert moved[[1, 2]] == pytest.approx(0.0)


def test_rotation_between_orientations() -> None:
    half = np.array([np.cos(0.2), 0.0, np.sin(0.2), 0.0])
    level = np.array([1.0, 0.0, 0.0, 0.0])
    assert rotation_between(level, half) == pytest.approx([0.0, 0.4, 0.0])
    assert rotation_between(level, -half) == pytest.approx([0.0, 0.4, 0.0])
    assert rotation_between(half, half) == pytest.approx(np.zeros(3))
    assert rotation_of(half) @ [0.0, 0.0, 1.0] == pytest.approx([np.sin(0.4), 0.0, np.cos(0.4)])
