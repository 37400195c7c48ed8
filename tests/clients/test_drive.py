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
def gait_map(checkout: Path) -> GaitMap:
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


def test_a_pilot_stands_until_it_is_asked_to_go_and_changes_by_transitions(gait_map: GaitMap) -> None:
    pilot = Pilot(gait_map)
    stand = pilot.motion
    assert pilot.tick(0.0, 0.0) is stand
    assert pilot.tick(0.02, 0.06) is stand  # less than the slowest, 0.2 m/s
    going = pilot.tick(0.04, 0.5)
    assert isinstance(going, Journey) and going.before is stand
    (change,) = pilot.changes
    assert change.found and change.gaits[0] is None and change.speeds == (0.0, pytest.approx(0.5))
    assert change.begins >= 0.04 + LEAD
    assert pilot.tick(0.06, 0.8) is going  # under way
    assert pilot.tick(change.settled, 0.53) is going  # noise
    faster = pilot.tick(change.settled, 0.8)
    assert isinstance(faster, Journey) and faster.before is going
    pilot.tick(faster.settled, 0.08)
    assert [change.gaits[1] is None for change in pilot.changes] == [False, False, True]
    assert pilot.changes[-1].found and pilot.changes[-1].speeds[1] == 0.0


def test_a_short_drive_does_not_fall(gait_map: GaitMap) -> None:
    scenario, pilot = gait_map.manifest.scenario, Pilot(gait_map)
    course = Course(0.6, 14.0)
    driven = drive(pilot, RobotModel.of(describe(scenario), scenario, pilot.first.task), course)
    data = driven.as_data()
    assert driven.fell is None and data["no_transition"] == 0
    assert len(driven.speeds) == len(driven.times) == 700
    assert driven.speeds.max() > 0.3 and driven.gait_changes <= borders(gait_map, course)
    assert driven.gaits[0] == (0.0, None) and len(driven.gaits) == 1 + len(driven.changes)
    assert abs(len(driven.frames) - 14 * 30) <= 2
