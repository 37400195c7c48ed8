"""kill -9 of workers and of whole runs, with the real solver."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.infrastructure.faults import Kill, Round, _difference, _row, faults
from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.store.journal import Entry


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_twenty_kills_change_nothing_and_repeat_nothing(checkout: Path) -> None:
    data = load_scenario(checkout / "configs/scenarios/quickstart.yaml").as_data()
    data["transcription"]["knots_per_phase"] = 4
    document = faults(Scenario.from_data(data, "test"), tasks=12, kills=20, seed=1, quiet_s=(0.2, 3.0))
    summary = document["summary"]
    assert summary["solutions"] > 0
    assert summary["kills"] == summary["ended"] == 20
    assert summary["repeated"] == 0 and summary["orphans"] == 0
    assert summary["cost_difference_max_rel"] <= 1e-9
    assert [row["kills"] for row in document["rows"]] == [10, 10]
    assert summary["lost_in_flight"] > 0, "no kill hit a solve: the test has shown nothing"


FRAME = pd.DataFrame(
    {
        "split": "grid",
        "cycle_duration": 0.4,
        "speed": [0.1, 0.3],
        "pattern": "0110/1100",
        "gait": "0110/1100",
        "seed": 0,
        "status": ["solved", "infeasible"],
        "cost": [5.0, float("nan")],
    }
)


def test_a_repeated_and_a_lost_unit_are_seen() -> None:
    def start(unit: str, time: float, solver: str) -> Entry:
        return Entry("start", unit, time, solver)

    journal = (start("a", 1.0, "7-x"), start("b", 2.0, "8-x"), start("b", 6.5, "9-x"), start("a", 8.0, "9-x"))
    each = Round((Kill("worker", 5.0, frozenset({8}), 0),), journal, {"a": 3.0, "b": 7.5}, FRAME)
    row = _row("worker", [each], [0.0])
    assert (row["repeated"], row["lost_in_flight"], row["recovered_s"], row["ended"]) == (1, 1, 1.5, 1)
    assert _row("worker", [each], [None])["ended"] == 0 and _row("run", [each], [0.0])["kills"] == 0


def test_a_changed_dataset_is_seen() -> None:
    assert _difference(FRAME, FRAME.copy()) == 0.0
    assert _difference(FRAME, None) is None
    assert _difference(FRAME, FRAME.assign(cost=[5.0 + 1e-7, float("nan")])) is None
    assert _difference(FRAME, FRAME.assign(cost=[5.0, 6.0])) is None
    assert _difference(FRAME, FRAME.assign(status="solved")) is None
    assert _difference(FRAME, FRAME.iloc[:1]) is None
