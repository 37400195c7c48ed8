"""Journeys between any two cycles: nothing jumps, and they are the motions that they lead from and to."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from bodies import PLANAR, SPATIAL
from cyclic import cyclic, cyclic_scenario
from hypothesis import given, settings
from hypothesis import strategies as st
from journeys import journeys, planned

from gaitflow.core.check import FEASIBLE, violations
from gaitflow.core.check_transition import violations_between
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.motion import Journey, Motion, State, standing

SMOOTH = (
    "position", "velocity", "orientation", "angular_velocity", "feet", "foot_velocities", "foot_accelerations",
)  # fmt: skip


def edges(journey: Journey) -> Array:
    """Every time of the transition at which something begins or ends."""
    transition, steps = journey.transition, journey.transition.plan.trajectory.times
    legs = [time for leg in transition.legs for time in (*leg.starts, *leg.ends, leg.joined)]
    return np.unique(np.concatenate([transition.start + steps, [transition.end], legs]))


@given(journeys())
@settings(max_examples=60, deadline=None)
def test_nothing_jumps(journey: Journey) -> None:
    borders = edges(journey)
    before, after = journey.sample(borders - 1e-11), journey.sample(borders + 1e-11)
    for name in SMOOTH:
        one, other = getattr(before, name), getattr(after, name)
        tolerance = 1e-4 if name == "foot_accelerations" else 1e-6
        np.testing.assert_allclose(one, other, atol=tolerance * max(1.0, np.abs(one).max()), err_msg=name)


@given(journeys(), st.integers(0, 2**31))
@settings(max_examples=40, deadline=None)
def test_rates_are_derivatives(journey: Journey, seed: int) -> None:
    borders, step = edges(journey), 1e-6
    times = np.random.default_rng(seed).uniform(borders[0] - 0.2, borders[-1] + 0.2, 40)
    waits = journey.sample(times).until_touchdown.min(axis=1)
    times = times[(np.abs(times[:, None] - borders).min(axis=1) > 1e-4) & (waits > 1e-4)]
    before, at, after = (journey.sample(times + shift) for shift in (-step, 0.0, step))
    for value, rate in (
        ("position", "velocity"),
        ("feet", "foot_velocities"),
        ("foot_velocities", "foot_accelerations"),
    ):
        slope = (getattr(after, value) - getattr(before, value)) / (2 * step)
        expected = getattr(at, rate)
        np.testing.assert_allclose(slope, expected, atol=1e-3 * max(1.0, np.abs(expected).max()), err_msg=value)


@given(journeys())
@settings(max_examples=40, deadline=None)
def test_feet_stand_still_where_they_stand_and_swing_above_the_ground(journey: Journey) -> None:
    start = journey.transition.start
    times = np.linspace(start - 0.3, journey.settled + 0.3, 700)
    seen = journey.sample(times)
    assert np.abs(seen.foot_velocities[seen.contact]).max(initial=0.0) == 0.0
    assert seen.feet[..., -1].min() > -1e-9
    step = times[1] - times[0]
    for leg, contact in enumerate(seen.contact.T):
        landings = times[1:][~contact[:-1] & contact[1:]]
        for time, wait in zip(times[::23], seen.until_touchdown[::23, leg], strict=True):
            following = landings[landings > time]
            if following.size:
                assert abs(following[0] - time - wait) <= 1.01 * step or wait < step, (leg, time)


@given(journeys())
@settings(max_examples=20, deadline=None)
def test_a_journey_is_the_motions_that_it_leads_from_and_to(journey: Journey) -> None:
    early = journey.transition.start - np.array([0.5, 0.01])
    late = journey.settled + np.array([0.01, 3.0])
    for times, part in ((early, journey.before), (late, journey.after)):
        seen, own = journey.sample(times), part.sample(times)
        for name in (each.name for each in fields(State) if each.name != "until_touchdown"):
            np.testing.assert_array_equal(getattr(seen, name), getattr(own, name))
    assert journey.sample([]).feet.shape == (0, *journey.at(0.0).feet.shape)
    alone = journey.at(float(late[0]))
    np.testing.assert_array_equal(alone.feet, journey.sample(late).feet[0])


@pytest.mark.parametrize(("robot", "slope"), [(PLANAR, 0.0), (PLANAR, -12.0), (SPATIAL, 0.0), (SPATIAL, 8.0)])
def test_standing_is_a_motion_that_obeys_the_check(robot: dict[str, Any], slope: float) -> None:
    data = cyclic_scenario(robot)
    task = Task.of({"speed": 0.7, "cycle_duration": 0.5, "slope": slope})
    pattern = "/".join(["1001"] * len(data["robot"]["legs"]))
    still = standing(Motion.of(data, cyclic(data, task, pattern, 0), task, pattern))
    found = violations(data, still.trajectory, still.task, still.pattern)
    assert max(found.values()) < 1e-9, found
    seen = still.sample([0.0, 12.3])
    np.testing.assert_allclose(seen.position[0], seen.position[1], atol=1e-12)
    assert np.abs(seen.acceleration).max() < 1e-9
    assert seen.contact.all()
    assert np.isinf(seen.until_touchdown).all()


def test_nobody_stands_on_ground_that_is_too_steep() -> None:
    data = cyclic_scenario(PLANAR)
    task = Task.of({"speed": 0.7, "cycle_duration": 0.5, "slope": 30.0, "friction": 0.5})
    motion = Motion.of(data, cyclic(data, task, "1001/0110", 0), task, "1001/0110")
    with pytest.raises(ValueError, match=r"slope = 30, friction = 0.5: the robot cannot stand there"):
        standing(motion)


def test_the_check_between_two_states_asks_for_them_instead_of_periodicity() -> None:
    data = cyclic_scenario(SPATIAL)
    task = Task.of({"speed": 0.7, "cycle_duration": 0.5})
    pattern = "1001/0110/0110/1001"
    plan = cyclic(data, task, pattern, 3)
    states = [np.concatenate([plan.base[knot], plan.feet[knot].ravel()]) for knot in (0, -1)]
    periodic = violations(data, plan, task, pattern)
    found = violations_between(data, plan, task, pattern, (states[0], states[1]))
    assert {key: value for key, value in periodic.items() if key != "periodicity"} | {"ends": 0.0} == found
    moved = states[1] + np.eye(len(states[1]))[-1] * 0.01
    off = violations_between(data, plan, task, pattern, (states[0], moved))["ends"]
    assert off == pytest.approx(0.01)
    assert off > FEASIBLE
    assert "ends" not in violations_between(data, replace(plan, feet=plan.feet[1:]), task, pattern, (states[0], moved))


def test_times_of_a_transition_are_its_own() -> None:
    data = cyclic_scenario(PLANAR)
    task = Task.of({"speed": 0.7, "cycle_duration": 0.5})
    motion = Motion.of(data, cyclic(data, task, "1001/0110", 0), task, "1001/0110")
    plan = planned(motion, motion, 0)
    journey = Journey.of(motion, plan, plan.first.since, motion)
    transition = journey.transition
    np.testing.assert_array_equal(transition.at(transition.start).feet, journey.at(transition.start).feet)
    with pytest.raises(ValueError, match=r"times\[1\] = .*: the transition is from"):
        transition.sample([transition.start, transition.end + 0.1])
    with pytest.raises(ValueError, match="finite number of seconds"):
        journey.at(float("nan"))
