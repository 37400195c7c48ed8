from __future__ import annotations

import numpy as np
import pytest
from journeys import planned as way
from walking_robots import model, planned

from gaitflow.clients.record import Moment, WalkRecord, record_of
from gaitflow.clients.simulation import Conditions, Push
from gaitflow.clients.walking import Walker, started, walk
from gaitflow.motion import Journey, standing


@pytest.mark.parametrize(("name", "speed", "cycle_duration"), [("anymal", 0.6, 0.6), ("go1", 0.6, 0.5)])
def test_robot_walks_at_its_speed(name: str, speed: float, cycle_duration: float) -> None:
    motion = planned(name, speed, cycle_duration)
    walked = walk(model(motion), motion, cycles=6)
    record = walked.record
    assert record.walked and record.fell is None
    assert record.velocity[0] == pytest.approx(speed, rel=0.05)
    assert record.distance == pytest.approx(speed * 6 * cycle_duration, rel=0.05)
    assert 0.1 < record.cost_of_transport < 1.5
    assert record.tilt < 0.06 and record.slip < 0.01 and record.position_error < 0.03
    assert record.stances == pytest.approx(24, abs=2)
    assert len(walked.frames) == pytest.approx(30 * 8 * cycle_duration, abs=2)
    assert len(walked.touching) == pytest.approx(8000 * cycle_duration, abs=4)


def test_mean_force_carries_the_weight() -> None:
    motion = planned("anymal", 0.6, 0.6)
    robot = model(motion)
    walker, moments = Walker(robot, motion), []
    while walker.time < 2 * motion.period - 1e-9:
        moments += walker.advance()
    lifted = np.array([moment.forces for moment in moments[600:]]).sum(axis=1).mean(axis=0)
    assert lifted == pytest.approx([0.0, 0.0, robot.mass * 9.81], abs=0.03 * robot.mass * 9.81)


def test_push_is_survived() -> None:
    motion = planned("anymal", 0.6, 0.6)
    pushes = (Push(1.5, (0.0, 0.3, 0.0)), Push(2.4, (0.3, 0.0, 0.0)))
    record = walk(model(motion), motion, cycles=4, conditions=Conditions(pushes=pushes)).record
    assert record.walked
    assert record.position_error < 0.1


def test_robot_that_is_knocked_over_has_fallen() -> None:
    motion = planned("go1", 0.6, 0.5)
    record = walk(model(motion), motion, cycles=2, conditions=Conditions(pushes=(Push(0.2, (0.0, 4.0, 0.0)),))).record
    assert not record.walked
    assert record.fell is not None and 0.2 < record.fell < 2.0


def test_walker_follows_another_motion_from_any_time_on() -> None:
    motion = planned("anymal", 0.6, 0.6)
    walker = Walker(model(motion), motion)
    while walker.time < 1.5:
        walker.advance()
        if round(walker.time * 1000) % 20 == 0:  # replanned at 50 Hz
            walker.follow(motion)
    assert not walker.fallen
    assert walker.simulation.measured.position[0] == pytest.approx(motion.at(1.5).position[0], abs=0.03)


def test_motion_of_the_centre_of_mass_is_refused() -> None:
    motion = planned("anymal", 0.6, 0.6)
    journey = Journey.of(motion.of_mass(), way(motion, standing(motion), 0), 0.0, standing(motion).of_mass())
    with pytest.raises(ValueError, match='point="base"'):
        started(model(motion), journey)
    with pytest.raises(ValueError, match='point="base"'):
        started(model(motion), motion.of_mass())
    with pytest.raises(ValueError, match="cycles = 0"):
        walk(model(motion), motion, cycles=0)


def moment(time: float, **changed) -> Moment:
    values = {
        "time": time,
        "position": np.array([0.5 * time, 0.0, 0.3]),
        "velocity": np.array([0.5, 0.0, 0.0]),
        "tilt": 0.1,
        "joint_velocity": np.array([1.0, 2.0]),
        "torque": np.array([3.0, -4.0]),
        "saturated": False,
        "heading": 0.0,
        "forces": np.array([[0.0, 0.0, 100.0], [0.0, 0.0, 0.0]]),
        "sliding": np.array([0.02, 5.0]),
        "planned_position": np.array([0.5 * time, 0.0, 0.31]),
        "planned_velocity": np.array([0.5, 0.0, 0.0]),
        "planned_heading": 0.0,
    }
    return Moment(**values | changed)


def test_record_of_moments_that_are_worked_out_by_hand() -> None:
    off = {"forces": np.zeros((2, 3))}
    landed = [moment(0.001 * i, **(off if 400 <= i < 500 else {})) for i in range(1000)]
    record = record_of(landed, 0.001, 10.0, None)
    assert record.walked
    assert record.distance == pytest.approx(0.5)
    assert record.cost_of_transport == pytest.approx(3.0 / (10 * 9.81 * 0.5), rel=1e-3)  # the other joint brakes
    assert record.heat == pytest.approx(25.0)
    assert record.mean_square_force == pytest.approx(0.9 * 100.0**2)
    assert record.stances == 1
    assert record.slip == pytest.approx(0.02 * 0.9)  # the foot in the air does not slip
    assert record.position_error == pytest.approx(0.01)
    assert record.impact == pytest.approx(100.0)


def test_walk_at_another_speed_is_not_walked() -> None:
    slow = [moment(0.001 * i, velocity=np.array([0.35, 0.0, 0.0])) for i in range(100)]
    assert not record_of(slow, 0.001, 10.0, None).walked
    assert record_of([moment(0.001 * i) for i in range(100)], 0.001, 10.0, None).walked
    assert not record_of([moment(0.001 * i) for i in range(100)], 0.001, 10.0, 0.05).walked


def test_walk_that_does_not_turn_as_commanded_is_not_walked() -> None:
    """Over 10 s at 0.8 rad/s, more than a whole turn."""

    def turning(rate: float) -> WalkRecord:
        times = 0.01 * np.arange(1001)
        still = {"velocity": np.zeros(3), "planned_velocity": np.zeros(3)}
        angles = [(-np.pi + rate * time) % (2 * np.pi) - np.pi for time in times]
        planned = [(-np.pi + 0.8 * time) % (2 * np.pi) - np.pi for time in times]
        each = zip(times, angles, planned, strict=True)
        moments = [moment(time, heading=one, planned_heading=other, **still) for time, one, other in each]
        return record_of(moments, 0.01, 10.0, None)

    assert turning(0.8).walked and turning(0.8).turning == pytest.approx(0.8, rel=0.01)
    assert turning(0.8).heading_error == pytest.approx(0.0, abs=1e-9)
    assert not turning(0.0).walked and turning(0.0).commanded_turning == pytest.approx(0.8, rel=0.01)
    assert turning(0.75).heading_error == pytest.approx(0.05 * 10 / np.sqrt(3), rel=0.01)
    assert turning(0.8).cost_of_transport is None
