"""Walks that no shipped map plans: turning, sideways, backwards, up and down, slippery, loaded."""

from __future__ import annotations

import numpy as np
import pytest
from solved_trots import solved_trot
from walking_robots import model

from gaitflow.clients.dynamics import Dynamics
from gaitflow.clients.rotation import turned
from gaitflow.clients.walking import started, walk
from gaitflow.motion.place import Place
from gaitflow.motion.placed import Placed


@pytest.mark.parametrize(
    "axes",
    [
        {"speed": 0.5, "yaw_rate": 0.7},
        {"lateral_speed": 0.25},
        {"speed": -0.5},
        {"speed": 0.3, "lateral_speed": 0.15, "yaw_rate": -0.4, "payload": 6.0},
        {"speed": 0.4, "friction": 0.35},
        {"speed": 0.4, "slope": 12.0, "payload": 5.0},
        {"speed": 0.5, "slope": -12.0},
        {"lateral_speed": 0.2, "slope": 10.0},
    ],
)
def test_robot_goes_where_it_is_commanded(axes: dict[str, float]) -> None:
    motion = solved_trot(**axes)
    record = walk(model(motion), motion, cycles=4).record
    assert record.walked, record
    speed, lateral, yaw_rate = (motion.task[axis] for axis in ("speed", "lateral_speed", "yaw_rate"))
    assert record.velocity == pytest.approx((speed, lateral), abs=0.02)
    assert record.turning == pytest.approx(yaw_rate, abs=0.01)
    assert record.cost_of_transport is not None and 0.05 < record.cost_of_transport < 1.0
    assert record.position_error < 0.02 and record.heading_error < 0.02 and record.slip < 0.003
    assert record.stances >= 14


def test_turning_on_the_spot_costs_no_transport() -> None:
    motion = solved_trot(yaw_rate=0.6)
    record = walk(model(motion), motion, cycles=3).record
    assert record.walked and record.cost_of_transport is None
    assert record.distance < 0.02 and record.turning == pytest.approx(0.6, abs=0.01)


def test_feet_begin_where_a_turned_motion_has_them() -> None:
    motion = solved_trot(speed=0.5, yaw_rate=0.7)
    robot, place = model(motion), Place(1.0 + 2.0j, 2.5)
    position, velocity = started(robot, Placed(motion, place, 0.0))
    centres = Dynamics(robot).centres(position)
    straight, pace = started(robot, motion)
    expected = place.points(Dynamics(robot).centres(straight))
    np.testing.assert_allclose(centres, expected, atol=1e-5)
    np.testing.assert_allclose(velocity[:3], turned(pace[None, :3], 2.5)[0], atol=1e-9)
    np.testing.assert_allclose(velocity[6:], pace[6:], atol=1e-3)
