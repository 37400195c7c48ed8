from __future__ import annotations

import json
import math
import platform
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import gaitflow
from benchmarks.document import document, plain, summary_table, write


def printed(done: dict) -> str:
    console = Console(width=200, record=True, file=open("/dev/null", "w", encoding="utf-8"))  # noqa: SIM115
    console.print(summary_table(done))
    return console.export_text()


def test_document_says_what_where_when_and_with_which_versions() -> None:
    done = document("discovery", "quickstart", [{"cost": 1.5}], {"tasks": 1}, ["read so"])
    assert list(done) == ["bench", "scenario", "date", "machine", "versions", "rows", "summary", "notes"]
    age = datetime.now(UTC) - datetime.fromisoformat(done["date"])
    assert abs(age.total_seconds()) < 10
    assert done["machine"]["cores"] >= 1
    assert done["machine"]["memory_gib"] > 0
    assert done["machine"]["cpu"]
    assert done["versions"]["gaitflow"]["version"] == gaitflow.__version__
    assert done["versions"]["numpy"] == np.__version__
    assert platform.node() not in json.dumps(done["machine"])


def test_what_json_cannot_hold_is_null_or_refused() -> None:
    data = {"a": (np.float64(1.5), math.nan), 2: [math.inf, np.int64(3), None, True], "s": np.array([1.0, -math.inf])}
    assert plain(data) == {"a": [1.5, None], "2": [None, 3, None, True], "s": [1.0, None]}
    with pytest.raises(TypeError, match=r"cannot hold a [A-Za-z]*Path"):
        plain({"file": Path("x")})


def test_written_under_its_bench_and_scenario_and_replaced_whole(tmp_path: Path) -> None:
    first = document("table1", "half-cheetah-flat-effort", [], {"tasks": 1})
    path = write(first, tmp_path / "results")
    assert path == tmp_path / "results" / "table1-half-cheetah-flat-effort.json"
    assert write(first | {"summary": {"tasks": 2}}, tmp_path / "results") == path
    assert json.loads(path.read_text(encoding="utf-8"))["summary"] == {"tasks": 2}
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    assert write(document("faults", None, [], {}), tmp_path).name == "faults.json"


@pytest.mark.parametrize(
    ("bench", "scenario"), [("../table1", "a"), ("table1", "a/../../b"), ("Table1", "a"), ("", "")]
)
def test_names_that_lead_elsewhere_are_refused(tmp_path: Path, bench: str, scenario: str) -> None:
    with pytest.raises(ValueError, match="lower-case words"):
        write(document(bench, scenario, [], {}), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_table_has_a_line_a_method_with_every_number() -> None:
    summary = {
        "minlp": {"time_mean_s": 31.25, "successful": 9, "consistent": None},
        "bounds": {"time_mean_s": 0.0512, "successful": 10, "consistent": 10, "runs": 10},
    }
    lines = printed(document("table1", "quickstart", [], summary)).splitlines()
    minlp, bounds = (next(line.split() for line in lines if name in line) for name in ("minlp", "bounds"))
    assert [cell for cell in minlp if cell != "│"] == ["minlp", "31.25", "9", "N/A", "N/A"]
    assert [cell for cell in bounds if cell != "│"] == ["bounds", "0.0512", "10", "10", "10"]


def test_table_of_plain_numbers_has_a_line_each() -> None:
    text = printed(document("stances", "quickstart", [], {"tasks": 84, "winners": {"F 01 / H 10": 3}, "worst": None}))
    for part in ("stances quickstart", "tasks", "84", "F 01 / H 10 3", "N/A"):
        assert part in text


def test_objects_of_objects_have_a_line_each_in_their_cell() -> None:
    targets = {"tasks": {"found": 3, "meets": False}, "fast_rate": {"found": 0.5, "meets": True}}
    lines = printed(document("online", "quickstart", [], {"tasks": 3, "targets": targets})).splitlines()
    assert any("targets" in line and "tasks found 3, meets False" in line and "fast_rate" not in line for line in lines)
    assert any("fast_rate found 0.5, meets True" in line for line in lines)
