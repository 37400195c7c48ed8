"""Stances of a journey: those that its states have, whole, and in every program's format."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from journeys import journeys, planned
from trotting import trot

from gaitflow.export.contact_parquet import write_contact_schedule
from gaitflow.motion import (
    Journey,
    Stance,
    gait_info,
    mode_schedule,
    schedule_data,
    schedule_json,
    standing,
    towr_formulation,
)
from gaitflow.motion.contact_schedule import intervals

GOLDEN = Path(__file__).parents[1] / "data" / "schedules"
NEAR = 1e-6  # s from an edge, where a state is one or the other


@st.composite
def parts(draw: st.DrawFn) -> tuple[Journey, tuple[float, float]]:
    """A journey and a span in which something of its transition is, or which is before or behind it."""
    journey = draw(journeys())
    transition = journey.transition
    edges = (transition.start, transition.end, journey.settled)
    start = draw(st.sampled_from(edges) | st.floats(transition.start - 3.0, journey.settled + 3.0))
    stop = draw(st.sampled_from(edges) | st.floats(transition.start - 2.0, journey.settled + 4.0))
    return journey, (start, stop) if stop > start + 1e-3 else (start, start + draw(st.floats(0.01, 2.0)))


@given(parts(), st.integers(0, 2**31))
@settings(max_examples=80, deadline=None)
def test_phases_are_when_and_where_feet_stand(part: tuple[Journey, tuple[float, float]], seed: int) -> None:
    journey, (start, stop) = part
    first, last = start + NEAR, stop - NEAR  # what ends or begins at an end of the span is not in it
    random = np.random.default_rng(seed).uniform(first, last, 300)
    seen = journey.sample(np.concatenate([random, np.linspace(first, last, 700)]))
    for number, leg in enumerate(journey.leg_names):
        stances = journey.phases(leg, (start, stop))
        assert all(each.start < stop and each.end > start for each in stances)
        assert all(one.end < other.start for one, other in pairwise(stances))
        edges = np.array([edge for each in stances for edge in each[:2]])
        clear = np.abs(seen.time[:, None] - edges).min(axis=1, initial=np.inf) > NEAR
        stands = np.zeros(len(seen.time), dtype=bool)
        for begin, end, foothold in stances:
            inside = (begin <= seen.time) & (seen.time < end)
            stands |= inside
            feet = seen.feet[inside & clear, number]
            np.testing.assert_allclose(feet, np.broadcast_to(foothold, feet.shape), atol=1e-7)
        np.testing.assert_array_equal(seen.contact[clear, number], stands[clear])


def reaches(stance: Stance, start: float, stop: float) -> bool:
    """Whether it does, by more than rounding."""
    return stance.start < stop - NEAR and stance.end > start + NEAR


@given(parts())
@settings(max_examples=60, deadline=None)
def test_stances_are_whole_wherever_a_span_cuts_them(part: tuple[Journey, tuple[float, float]]) -> None:
    journey, (start, stop) = part
    for number in range(len(journey.leg_names)):
        every = journey.phases(number, (start - 5.0, stop + 5.0))
        expected = [each for each in every if reaches(each, start, stop)]
        found = [each for each in journey.phases(number, (start, stop)) if reaches(each, start, stop)]
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert one[:2] == pytest.approx(other[:2], abs=1e-9)
            np.testing.assert_allclose(one.foothold, other.foothold, atol=1e-9)


@given(parts())
@settings(max_examples=30, deadline=None)
def test_intervals_cover_the_span(part: tuple[Journey, tuple[float, float]]) -> None:
    journey, span = part
    found = intervals(journey, span=span)
    assert (found[0].start, found[-1].end) == span
    assert all(one.end == other.start and one.contact != other.contact for one, other in pairwise(found))
    for each in found:
        seen = journey.sample(np.linspace(each.start + NEAR, max(each.end - NEAR, each.start + NEAR), 5)).contact
        assert (seen == each.contact).all() or each.end - each.start < 3 * NEAR
    assert json.loads(schedule_json(journey, span=span)) == schedule_data(journey, span=span)


@pytest.fixture(scope="module")
def stopping() -> Journey:
    """A trot until 1.6 s that comes to a stand in 0.7 s."""
    motion = trot()
    return Journey.of(motion, planned(motion, standing(motion), 0), 1.6, standing(motion))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("journey.json", lambda journey: schedule_json(journey, span=(1.0, 3.0))),
        ("journey.info", lambda journey: mode_schedule(journey, (1.0, 3.0))),
        ("journey.towr", lambda journey: towr_formulation(journey, span=(1.0, 3.0))),
    ],
)
def test_golden_files(stopping: Journey, name: str, text: Any) -> None:
    assert text(stopping) == (GOLDEN / name).read_text()


def test_a_stand_is_never_left(stopping: Journey) -> None:
    assert stopping.phases("LF", (1.0, 3.0))[-1].end == np.inf
    data = schedule_data(stopping, span=(1.0, 3.0))
    assert {each[-1]["end"] for each in data["stances"].values()} == {None}
    assert data["span"] == [1.0, 3.0] and "cycles" not in data


def test_durations_of_towr_add_up_to_the_span(stopping: Journey) -> None:
    lines = [line for line in towr_formulation(stopping, span=(1.05, 2.9)).splitlines() if "durations" in line]
    for line in lines:
        parts = [float(part) for part in line[line.index("{") + 1 : line.index("}")].split(",")]
        assert sum(parts) == pytest.approx(1.85, abs=1e-8) and min(parts) > 0


def test_a_table_of_a_journey(stopping: Journey, tmp_path: Path) -> None:
    write_contact_schedule(tmp_path / "journey.parquet", stopping, span=(1.0, 3.0))
    table = pq.read_table(tmp_path / "journey.parquet")
    assert table.schema.metadata == {b"legs": b"LF,RF,LH,RH", b"span": b"1.0,3.0"}
    expected = [(leg, *stance[:2]) for leg in stopping.leg_names for stance in stopping.phases(leg, (1.0, 3.0))]
    assert [(row["leg"], row["start"], row["end"]) for row in table.to_pylist()] == expected


def test_a_motion_has_spans_too() -> None:
    motion = trot()
    assert schedule_data(motion, 2)["stances"] == schedule_data(motion, span=(0.0, 1.6))["stances"]
    (stance,) = motion.phases("RF", span=(100.05, 100.1))  # in the 126th cycle
    assert stance[:2] == pytest.approx((100.0, 100.4))
    assert stance.foothold[0] == pytest.approx(motion.at(100.2).feet[1, 0])
    assert "eventTimes\n  {\n    [0]     0.4\n  }" in mode_schedule(motion, (0.0, 0.8), "trot")


def test_what_a_journey_is_not_asked_for(stopping: Journey) -> None:
    for ask in (schedule_json, towr_formulation, intervals):
        with pytest.raises(ValueError, match=r"a journey has no cycles: say by span=\(start, stop\)"):
            ask(stopping)
    with pytest.raises(ValueError, match="ask for mode_schedule"):
        gait_info(stopping, "trot")
    with pytest.raises(ValueError, match="leg = 'XX': the legs are 0 LF"):
        stopping.phases("XX", (0.0, 1.0))
    for span in ((1.0, 1.0), (2.0, 1.0), (0.0, float("inf")), 3.0, (0.0, 1.0, 2.0)):
        with pytest.raises(ValueError, match="span"):
            stopping.phases("LF", span)  # type: ignore[arg-type]
