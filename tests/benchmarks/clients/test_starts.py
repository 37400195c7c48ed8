from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.clients.starts import run
from benchmarks.document import plain

STARTS = ["plan", "plan, cold", "plan's swings", "plan's swings, cold", "trot", "trot, cold"]


def test_a_row_for_each_start_of_the_same_task(checkout: Path) -> None:
    done = run(checkout / "models" / "anymal-exact-vibration" / "1.0.0", tasks=1, seed=3)
    assert done["bench"] == "clients" and done["scenario"] == "anymal-exact-vibration"
    assert plain(done) == done
    assert [row["start"] for row in done["rows"]] == STARTS == list(done["summary"])
    assert len({(row["speed"], row["cycle_duration"]) for row in done["rows"]}) == 1
    for solver in ("crocoddyl", "fatrop"):
        costs = [row[solver]["cost"] for row in done["rows"]]
        assert all(row[solver]["ready"] for row in done["rows"])
        assert costs[0] == pytest.approx(costs[1], rel=0.02)
        assert costs[2] == pytest.approx(costs[3], rel=0.02)
        assert costs[4] == pytest.approx(costs[5], rel=0.02)
        assert costs[0] != pytest.approx(costs[4], rel=1e-3)
