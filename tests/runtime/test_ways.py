"""Ways from one gait to another: contacts that both gaits allow, the most promising first."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import PLANAR, SPATIAL
from cyclic import cyclic, cyclic_scenario

from gaitflow.core.task import Task
from gaitflow.motion import Motion, standing
from gaitflow.motion.phase_start import phase_starts
from gaitflow.runtime.way import Way, stances
from gaitflow.runtime.ways import ways

TROT, WALK = "0011/1100/1100/0011", "0111/1011/1101/1110"


def motion_of(pattern: str, speed: float = 0.5) -> Motion:
    data = cyclic_scenario(SPATIAL if pattern.count("/") == 3 else PLANAR)
    task = Task.of({"speed": speed, "cycle_duration": 0.6})
    return Motion.of(data, cyclic(data, task, pattern, 1), task, pattern)


def found(one: Motion, other: Motion) -> list[Way]:
    task = Task.of({"speed": 0.5, "cycle_duration": 0.7})
    return ways(one.scenario, phase_starts(one), phase_starts(other), task)


@pytest.mark.parametrize(("one", "other"), [(TROT, WALK), (WALK, TROT), ("0011/0110", "0001/0100")])
def test_contacts_are_of_the_one_gait_then_of_the_other(one: str, other: str) -> None:
    motions = motion_of(one), motion_of(other)
    every = found(*motions)
    assert every
    assert len({(way.first.since, way.last.since, way.pattern) for way in every}) == len(every)
    for way in every:
        phases = range(5)
        begins, ends = way.first.contacts, way.last.contacts
        assert any((way.contacts[:n] == begins[:n]).all() and (way.contacts[n:] == ends[n:]).all() for n in phases)
        assert not way.contacts.all(axis=0).any()
        assert not way.contacts[0][way.first.swinging].any()
        assert not way.contacts[-1][way.last.swinging].any()
        assert way.durations.sum() == pytest.approx(0.7)
        assert way.durations.min() >= 0.1 * 0.7 - 1e-12


def test_standing_may_be_left_and_joined_at_any_time() -> None:
    trot = motion_of(TROT)
    still = standing(trot)
    assert len(phase_starts(still)) == 1
    for every in (found(still, trot), found(trot, still)):
        assert every
        assert all(not way.contacts.all(axis=0).any() for way in every)


def test_a_way_on_which_legs_can_carry_the_body_comes_first() -> None:
    """Between a trot and one with flight, that is one that flies less."""
    every = found(motion_of(TROT, speed=0.0), motion_of("0001/0100/0100/0001", speed=0.0))
    flights = [int((~way.contacts.any(axis=1)).sum()) for way in every]
    assert flights[0] == min(flights) < max(flights)


def test_stances_of_a_row() -> None:
    assert stances(np.array([True, False, True, True])) == [(0, 1), (2, 4)]
    assert stances(np.array([False, False])) == []
