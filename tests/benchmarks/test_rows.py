from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks import rows
from benchmarks.paper import big_m
from benchmarks.rows import Row, RowStore
from gaitflow.config.scenario import Scenario

KEYS = [{"speed": 0.1 * n, "method": "patterns", "seed": None} for n in range(4)]


class Measuring:
    """Counts what it measures; dies at the `fatal`-th call."""

    def __init__(self, fatal: int | None = None) -> None:
        self.keys: list[Row] = []
        self._fatal = fatal

    def __call__(self, key: Row) -> Row:
        if len(self.keys) == self._fatal:
            raise KeyboardInterrupt
        self.keys.append(key)
        return {"cost": 10 * key["speed"], "violation": float("nan")}


def store(scenario: Scenario, folder: Path, **changes) -> RowStore:
    return RowStore(**{"bench": "discovery", "scenario": scenario, "runs": folder, "measuring": [rows]} | changes)


def test_a_second_call_measures_nothing(scenario: Scenario, tmp_path: Path) -> None:
    first, second = Measuring(), Measuring()
    made = store(scenario, tmp_path).rows(KEYS, first)
    again = store(scenario, tmp_path).rows(KEYS, second)
    assert first.keys == KEYS
    assert second.keys == []
    assert again == made
    assert [row["cost"] for row in made] == [10 * key["speed"] for key in KEYS]
    assert made[0]["violation"] is None
    assert made[0]["measured"].endswith("+00:00")


def test_a_stopped_bench_goes_on_where_it_was(scenario: Scenario, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        store(scenario, tmp_path).rows(KEYS, Measuring(fatal=3))
    rest = Measuring()
    found = store(scenario, tmp_path).rows(KEYS, rest)
    assert rest.keys == KEYS[3:]
    assert [row["speed"] for row in found] == [key["speed"] for key in KEYS]


def test_more_rows_keep_those_measured_before(scenario: Scenario, tmp_path: Path) -> None:
    store(scenario, tmp_path).rows(KEYS[1:3], Measuring())
    more = Measuring()
    store(scenario, tmp_path).rows(KEYS, more)
    assert more.keys == [KEYS[0], KEYS[3]]


def test_whatever_a_row_depends_on_measures_it_anew(scenario: Scenario, tmp_path: Path, monkeypatch) -> None:
    def measured(**changes) -> int:
        measuring = Measuring()
        store(**{"scenario": scenario, "folder": tmp_path} | changes).rows(KEYS, measuring)
        return len(measuring.keys)

    assert measured() == 4
    heavier = scenario.model_copy(update={"robot": scenario.robot.model_copy(update={"mass": 15.0})})
    assert measured(scenario=heavier) == 4
    assert measured(scenario=scenario.model_copy(update={"strategy": heavier.strategy.model_copy(
        update={"restarts": 2})})) == 4  # fmt: skip
    assert measured(about={"manifest": "1" * 64}) == 4
    assert measured(measuring=[rows, big_m]) == 4
    assert measured(bench="table1") == 4
    assert measured(scenario=scenario.model_copy(update={"description": "the same problem"})) == 0
    monkeypatch.setattr(rows, "solver_version", lambda: {"code": "another", "casadi": "3.8.2"})
    assert measured() == 4
    monkeypatch.setattr(rows, "machine", lambda: {"cpu": "another"})
    assert measured() == 4


@pytest.mark.parametrize("damage", [b"", b"{", b"[]", b'{"key": {}, "row": {}}', b'{"row": {}}', b"\xff\xfe"])
def test_a_damaged_row_is_named_and_measured_again(
    scenario: Scenario, tmp_path: Path, damage: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    kept = store(scenario, tmp_path)
    kept.rows(KEYS, Measuring())
    kept.path(KEYS[2]).write_bytes(damage)
    again = Measuring()
    assert [row["speed"] for row in kept.rows(KEYS, again)] == [key["speed"] for key in KEYS]
    assert again.keys == [KEYS[2]]
    assert f"{kept.path(KEYS[2])}: cannot be used" in capsys.readouterr().err
    assert json.loads(kept.path(KEYS[2]).read_bytes())["row"]["speed"] == KEYS[2]["speed"]


def test_progress_counts_and_gives_the_time_left(
    scenario: Scenario, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store(scenario, tmp_path).rows(KEYS[:1], Measuring())
    capsys.readouterr()
    store(scenario, tmp_path).rows(KEYS, Measuring())
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "discovery quickstart: 1 of 4 rows"
    assert lines[1].startswith("discovery quickstart: 2 of 4 rows, 0:00:0")
    assert lines[1].endswith(" to go")
    assert lines[-1].startswith("discovery quickstart: 4 rows in ")
    store(scenario, tmp_path).rows(KEYS, Measuring())
    assert capsys.readouterr().err == ""
