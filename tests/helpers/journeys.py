"""Journeys between any two cycles, for Hypothesis; no solver has made them."""

from __future__ import annotations

from typing import Any

from bodies import PLANAR, SPATIAL
from cyclic import cyclic, cyclic_scenario
from hypothesis import strategies as st

from gaitflow.core.layout import Layout
from gaitflow.core.task import Task
from gaitflow.motion import Journey, Motion
from gaitflow.motion.phase_start import phase_starts
from gaitflow.motion.transition import PlannedTransition
from gaitflow.runtime.way import end_states, interpolated
from gaitflow.runtime.ways import ways

ROWS = ("0110", "1100", "0011", "1001", "0111", "0001")


def motion_of(data: dict[str, Any], draw: st.DrawFn, slope: float) -> Motion:
    legs = len(data["robot"]["legs"])
    axes = {"speed": draw(st.floats(-0.5, 1.5)), "cycle_duration": draw(st.floats(0.3, 1.0)), "slope": slope}
    if legs == 4:
        axes |= {"lateral_speed": draw(st.floats(-0.3, 0.3)), "yaw_rate": draw(st.sampled_from([0.0, 0.9, -0.5]))}
    pattern = "/".join(draw(st.lists(st.sampled_from(ROWS), min_size=legs, max_size=legs)))
    task = Task.of(axes)
    return Motion.of(data, cyclic(data, task, pattern, draw(st.integers(0, 2**31))), task, pattern)


def planned(motion: Motion, other: Motion, seed: int) -> PlannedTransition:
    """Any transition: the motion from which a planner would start. It obeys no dynamics, and fits at both ends."""
    one, two, duration = motion.task, other.task, 0.7
    axes = ("speed", "lateral_speed", "yaw_rate", "slope")
    values = {axis: (one[axis] + two[axis]) / 2 for axis in axes}
    task = Task.of(values | {"acceleration": (two.speed - one.speed) / duration, "cycle_duration": duration})
    found = ways(motion.scenario, phase_starts(motion), phase_starts(other), task)
    way = found[seed % len(found)]
    first, last = end_states(way, task)
    times = Layout.of(motion.scenario).times(way.durations)
    times[-1] = duration
    trajectory = interpolated(motion.scenario, way, first, last, times)
    return PlannedTransition(way.first, way.last, way.pattern, task, trajectory, 0.0, 0.0)


@st.composite
def journeys(draw: st.DrawFn) -> Journey:
    data = cyclic_scenario(SPATIAL if draw(st.booleans()) else PLANAR)
    slope = 0.0 if data["robot"]["dimension"] == 3 else draw(st.sampled_from([0.0, 10.0]))
    motion, other, third = (motion_of(data, draw, slope) for _ in range(3))
    plan = planned(motion, other, draw(st.integers(0, 1000)))
    start = plan.first.since + draw(st.integers(-2, 3)) * motion.period
    journey = Journey.of(motion, plan, start, other)
    if draw(st.booleans()):
        onward = planned(other, third, draw(st.integers(0, 1000)))
        journey = Journey.of(journey, onward, journey.after.next_time(onward.first.since, journey.settled), third)
    return journey
