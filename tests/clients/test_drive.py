"""A robot driven by speed alone: the course, a pilot's decisions, and a short drive in MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gaitflow.clients.description import describe
from gaitflow.clients.drive import Course, borders, drive
from gaitflow.clients.pilot import LEAD, RATE, SMOOTHING, Pilot
from gaitflow.clients.robot_model import RobotModel
from gaitflow.motion import Journey, Motion
from gaitflow.runtime import GaitMap


@pytest.fixture(scope="module")
def energy(checkout: Path) -> GaitMap:
    return GaitMap.load(checkout / "models" / "anymal-energy")


def test_a_course_goes_up_and_down_and_ends_at_rest() -> None:
    course = Course(1.2, 60.0, noise=0.0)
    asked = course.asked()
    assert len(asked) == 3000 and asked.max() == 1.2 and asked[0] == 0.0
    assert (asked[2750:] == 0.0).all()
    assert (np.diff(asked[:1000]) > 0).all()
    noisy = Course(1.2, 60.0, noise=0.02, seed=3).asked()
    assert np.std(noisy - asked) == pytest.approx(0.02, rel=0.1)
    np.testing.assert_array_equal(noisy, Course(1.2, 60.0, noise=0.02, seed=3).asked())


def test_a_pilot_stands_until_it_is_asked_to_go_and_changes_by_transitions(energy: GaitMap) -> None:
    pilot = Pilot(energy)
    stand = pilot.motion
    assert held(pilot, 0.0, 0.0) is stand
    assert held(pilot, 1.0, 0.15) is stand  # less than the slowest, 0.2 m/s
    going = held(pilot, 2.0, 0.4)
    assert isinstance(going, Journey) and going.before is stand
    (change,) = pilot.changes
    assert change.found and change.gaits[0] is None and change.speeds[0] == 0.0
    assert change.speeds[1] == pytest.approx(0.4)  # none on the way
    assert change.begins >= change.decided + LEAD
    assert pilot.tick(change.settled - 0.02, 0.8) is going  # under way
    at = change.speeds[1]
    assert held(pilot, change.settled, at + 0.02) is going
    faster = held(pilot, change.settled + 1, at + 0.2)
    assert isinstance(faster, Journey) and faster.before is going
    held(pilot, faster.settled, 0.04)
    assert [change.gaits[1] is None for change in pilot.changes] == [False, False, True]
    assert pilot.changes[-1].found and pilot.changes[-1].speeds[1] == 0.0


def test_noise_on_the_command_changes_nothing(energy: GaitMap) -> None:
    pilot = Pilot(energy)
    going = held(pilot, 0.0, 0.6)
    assert isinstance(going, Journey)
    settled, at = going.settled, pilot.changes[-1].speeds[1]
    rng = np.random.default_rng(0)
    noisy = [pilot.tick(settled + tick / RATE, at + rng.normal(0.0, 0.02)) for tick in range(250)]
    assert all(motion is going for motion in noisy)


def test_borders_are_where_the_best_gait_changes(energy: GaitMap) -> None:
    pilot = Pilot(energy)
    assert pilot.answer(0.5).gait != pilot.answer(1.2).gait
    assert borders(pilot, Course(1.2, 10.0)) >= 2
    assert borders(pilot, Course(0.2, 10.0)) == 0


def test_cycles_are_kept_that_two_feet_can_balance(energy: GaitMap) -> None:
    assert energy.select(speed=0.3).cycle_duration > 1.0
    assert Pilot(energy).answer(0.3).cycle_duration <= 0.65  # three times the square root of 0.46 m over gravity


def test_a_pilot_of_an_energy_map_finds_all_its_transitions(energy: GaitMap) -> None:
    pilot = Pilot(energy)
    now = 0.0
    for speed in (0.3, 0.6, 0.9, 1.2, 0.7, 0.2, 0.0):
        motion = held(pilot, now, speed)
        assert isinstance(motion, Journey)
        now = motion.settled
    assert len(pilot.changes) == 7 and all(change.found for change in pilot.changes)


def held(pilot: Pilot, now: float, asked: float) -> Motion | Journey:
    """What is followed after a speed was asked for as long as the pilot listens."""
    ticks = round(SMOOTHING * RATE)
    motions = [pilot.tick(now + tick / RATE, asked) for tick in range(ticks)]
    return motions[-1]


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
