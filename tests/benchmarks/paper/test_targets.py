from __future__ import annotations

import pytest

from benchmarks.paper.targets import against

GOOD = {
    "tasks": 1000, "feasible_rate": 1.0, "consistent_tasks": 64, "consistent_rate": 0.99, "fast_rate": 0.98,
    "plan_ms_p50": 5.0, "plan_ms_p99": 15.0, "speedup_vs_paper_median": 100.0, "select_us_p50": 30.0,
}  # fmt: skip


def test_a_limit_itself_is_met_in_the_plane_and_its_numbers_do_in_space() -> None:
    for dimension in (2, 3):
        told = against(GOOD, dimension)
        assert list(told) == list(GOOD)
        assert all(target["meets"] for target in told.values()), told
    assert told["plan_ms_p50"] == {"at_most": 25.0, "found": 5.0, "meets": True}


@pytest.mark.parametrize("number", GOOD)
def test_a_miss_is_told_by_its_own_number(number: str) -> None:
    worse = GOOD[number] * (1.001 if number.startswith(("plan_ms", "select_us")) else 0.05)
    for found in (worse, None):
        told = against(GOOD | {number: found}, 2)
        assert told[number]["found"] == found
        assert [name for name, target in told.items() if not target["meets"]] == [number]
