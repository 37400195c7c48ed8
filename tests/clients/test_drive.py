"""A robot driven by speed alone: the course, a pilot's decisions, and a short drive in MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gaitflow.clients.description import describe
from gaitflow.clients.drive import Course, borders, drive
from gaitflow.clients.pilot import LEAD, Pilot
from gaitflow.clients.robot_model import RobotModel
from gaitflow.motion import Journey
from gaitflow.runtime import GaitMap


@pytest.fixture(scope="module")
def energy(checkout: Path) -> GaitMap:
    return GaitMap.load(checkout / "models" / "anymal-energy")


@pytest.fixture(scope="module")
def vibration(checkout: Path) -> GaitMap:
    """A map that plans transitions in a fifth of the time."""
    return GaitMap.load(checkout / "models" / "anymal-exact-vibration")


def test_a_course_goes_up_and_down_and_ends_at_rest() -> None:
    course = Course(1.2, 60.0, noise=0.0)
    asked = course.asked()
    assert len(asked) == 3000 and asked.max() == 1.2 and asked[0] == 0.0
    assert (asked[2750:] == 0.0).all()
    assert (np.diff(asked[:1000]) > 0).all()
    noisy = Course(1.2, 60.0, noise=0.02, seed=3).asked()
    assert np.std(noisy - asked) == pytest.approx(0.02, rel=0.1)
    np.testing.assert_array_equal(noisy, Course(1.2, 60.0, noise=0.02, seed=3).asked())


def test_a_pilot_stands_until_it_is_asked_to_go_and_changes_by_transitions(vibration: GaitMap) -> None:
    pilot = Pilot(vibration)
    stand = pilot.motion
    assert pilot.tick(0.0, 0.0) is stand
    assert pilot.tick(0.02, 0.06) is stand  # less than the slowest, 0.1 m/s
    going = pilot.tick(0.04, 0.3)
    assert isinstance(going, Journey) and going.before is stand
    (change,) = pilot.changes
    assert change.found and change.gaits[0] is None and change.speeds == (0.0, pytest.approx(0.3))
    assert change.begins >= 0.04 + LEAD
    assert pilot.tick(0.06, 0.6) is going  # under way
    assert pilot.tick(change.settled, 0.33) is going  # noise
    faster = pilot.tick(change.settled, 0.5)
    assert isinstance(faster, Journey) and faster.before is going
    pilot.tick(faster.settled, 0.04)
    assert [change.gaits[1] is None for change in pilot.changes] == [False, False, True]
    assert pilot.changes[-1].found and pilot.changes[-1].speeds[1] == 0.0


def test_borders_are_where_the_best_gait_changes(vibration: GaitMap) -> None:
    gaits = [vibration.select(speed=speed).gait for speed in (0.1, 1.3)]
    assert gaits[0] != gaits[1] and borders(vibration, Course(1.3, 10.0)) >= 2


def test_cycles_are_kept_that_two_feet_can_balance(energy: GaitMap) -> None:
    assert energy.select(speed=0.3).cycle_duration > 1.0
    assert Pilot(energy).first.period <= 0.87  # four times the square root of 0.46 m over gravity


@pytest.mark.slow
def test_a_short_drive_does_not_fall(energy: GaitMap) -> None:
    scenario, pilot = energy.manifest.scenario, Pilot(energy)
    course = Course(0.6, 10.0)
    driven = drive(pilot, RobotModel.of(describe(scenario), scenario, pilot.first.task), course)
    assert driven.fell is None
    assert len(driven.speeds) == len(driven.times) == 500
    assert driven.speeds.max() > 0.15
    assert driven.gaits[0] == (0.0, None) and len(driven.gaits) == 1 + sum(change.found for change in driven.changes)
    assert abs(len(driven.frames) - 10 * 30) <= 2
