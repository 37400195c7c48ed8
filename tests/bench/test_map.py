from __future__ import annotations

import pytest

from gaitflow.bench.map import PAUSE_S, active_seconds
from gaitflow.execute.journal import Entry


def stored(end: float, wall: float) -> Entry:
    return Entry("stored", "unit", end, "solver", cpu_s=wall, wall_s=wall, kept=True)


def test_units_side_by_side_count_once() -> None:
    assert active_seconds([stored(100.0, 60.0), stored(90.0, 50.0)]) == pytest.approx(60.0)


def test_a_pause_between_sessions_is_left_out() -> None:
    first, later = stored(60.0, 60.0), stored(60.0 + PAUSE_S + 1000.0, 30.0)
    assert active_seconds([first, later]) == pytest.approx(90.0)


def test_the_moments_between_units_belong_to_the_run() -> None:
    assert active_seconds([stored(60.0, 60.0), stored(130.0, 65.0)]) == pytest.approx(130.0)


def test_no_journal_is_no_time() -> None:
    assert active_seconds([Entry("start", "unit", 5.0, "solver")]) == 0.0
