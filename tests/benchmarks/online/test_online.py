from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from planted_child import PlantedChild

from benchmarks import child, measure
from benchmarks.child import Lost
from benchmarks.online import online
from benchmarks.online.online import calibration_error, judge, run, summarise
from benchmarks.paper.fixed_gait import scenario_of
from benchmarks.paper.random_start import METHODS
from gaitflow.cli import main
from gaitflow.core.gaits import Symmetry

GALLOP, WALKING = "0011/0110", "0111/1101"


def planned(cost: float = 100.0, **changes: Any) -> dict[str, Any]:
    row = {
        "speed": 1.234567, "cycle_duration": 0.654321, "gait": "gallop", "pattern": GALLOP, "path": "fast",
        "feasible": True, "cost": cost, "violation": 1.23456789e-9, "first": "gallop", "iterations": 5,
        "wall_ms": 4.0, "cpu_ms": 2.0,
        "select_ms": 0.1, "predict_ms": 0.4, "refine_ms": 3.5, "picked": "gallop", "probability": 0.9,
    }  # fmt: skip
    return row | changes


def searched(cost: float | None = 100.0, gait: str | None = "gallop", pattern: str | None = GALLOP) -> dict[str, Any]:
    return {"speed": 1.234567, "cycle_duration": 0.654321, "gait": gait, "pattern": pattern, "cost": cost}


def calls(plan_s: float, big_m_s: float, big_m_cost: float | None = 100.0) -> dict[str, Any]:
    found = {"gait": "gallop", "pattern": GALLOP, "status": "solved", "cost": 100.0, "iterations": 5}
    big_m = {"cost": big_m_cost, "status": "failed" if big_m_cost is None else "solved", "cpu_s": big_m_s}
    times = {method: {"cpu_s": 0.04, "wall_s": 0.05} for method in METHODS}
    times |= {"plan": {"cpu_s": plan_s, "wall_s": 2 * plan_s}, "bigm_random": big_m | {"wall_s": big_m_s}}
    return {method: found | times[method] for method in METHODS}


@pytest.mark.parametrize(
    ("row", "reference", "consistent", "within", "better"),
    [
        (planned(100.05), searched(), True, True, False),
        (planned(99.95), searched(), True, True, False),
        (planned(99.0), searched(), True, True, True),
        (planned(120.0), searched(), True, False, False),
        (planned(120.0, pattern="0110/1100"), searched(), True, False, False),  # the same cycle, cut elsewhere
        (planned(100.05, gait="walking", pattern=WALKING), searched(), True, True, False),
        (planned(100.2, gait="walking", pattern=WALKING), searched(), False, False, False),
        (planned(100.0, path="next:1"), searched(), True, True, False),
        (planned(100.0, path="failed"), searched(), False, False, False),
        (planned(math.nan, path="failed", feasible=False), searched(), False, False, False),
        (planned(100.0), searched(None, None, None), False, False, False),
    ],
)
def test_consistent_is_the_best_gait_or_the_best_cost(
    row: dict[str, Any], reference: dict[str, Any], consistent: bool, within: bool, better: bool
) -> None:
    (judged,) = judge([row], [reference], [])
    told = judged["reference"]
    assert (told["consistent"], told["within"], told["better"]) == (consistent, within, better)
    if row["path"] != "failed" and reference["cost"] is not None:
        assert told["excess"] == pytest.approx(row["cost"] / 100 - 1)
    else:
        assert told["excess"] is None


def test_a_gait_and_its_time_reversal_are_one_where_the_task_says_so() -> None:
    pronking, reversed_ = "0110/0100", "0010/0110"  # rows run backwards, front and hind exchanged
    row, reference = planned(120.0, pattern=pronking), searched(100.0, "gallop-pronk", reversed_)
    symmetries = [Symmetry(), Symmetry(reversal=(1, 0))]
    told = [judge([row], [reference], [], [each])[0]["reference"]["consistent"] for each in symmetries]
    assert told == [False, True]


def test_references_and_the_papers_way_belong_to_the_first_tasks() -> None:
    rows = judge([planned(), planned(), planned()], [searched(), searched(99.0)], [calls(0.004, 1.0, 100.2)])
    assert [("reference" in row, "paper" in row) for row in rows] == [(True, True), (True, False), (False, False)]
    assert [rows[0]["paper"][method]["optimal"] for method in METHODS] == [True, True, True, False]


def test_the_summary_counts_every_task() -> None:
    rows = [planned(wall_ms=float(ms), cpu_ms=ms / 2) for ms in range(1, 99)]
    rows += [planned(130.0, wall_ms=400.0, path="fallback", gait="walking", pattern=WALKING, picked="gallop")]
    rows += [planned(wall_ms=500.0, path="failed", feasible=False)]
    references = [searched()] * 2 + [searched(None, None, None)] + [searched()] * 97
    paper = [calls(0.004, 0.4), calls(0.004, 1.2), calls(0.002, 1.6, None)]
    told = summarise(judge(rows, references, paper), [10.0, 12.0, 50.0])
    assert (told["tasks"], told["feasible_rate"], told["fast_rate"]) == (100, 0.99, 0.98)
    assert told["paths"] == {"fast": 98, "fallback": 1, "failed": 1}
    assert (told["consistent_tasks"], told["consistent_rate"]) == (99, 97 / 99)
    assert told["excess_worst_inconsistent"] == pytest.approx(0.3)
    assert told["excess_worst_consistent"] == 0.0
    assert (told["plan_ms_p50"], told["plan_ms_max"], told["select_us_p50"]) == (50.5, 500.0, 12.0)
    assert told["plan_ms_p99"] == pytest.approx(401.0)
    assert told["plan_cpu_ms_p50"] < told["plan_ms_p50"]
    assert (told["same_as_select_rate"], told["first_as_select_rate"]) == (0.99, 1.0)
    assert told["speedup_vs_paper_median"] == pytest.approx(300.0), "of 100, 300 and 800"
    big_m = told["speedup"]["bigm_random"]
    assert big_m["of_medians"] == pytest.approx(1.2 / 0.004)
    assert big_m["wall_median"] == pytest.approx(150.0)
    told_of_big_m = told["methods"]["bigm_random"]
    assert (told_of_big_m["runs"], told_of_big_m["successful"], told_of_big_m["optimal"]) == (3, 2, 2)
    assert told_of_big_m["time_mean_s"] == pytest.approx(3.2 / 3), "a failed run counts with its time"


def test_calibration_error_is_the_gap_between_probability_and_share() -> None:
    assert calibration_error([], []) is None
    assert calibration_error([1.0, 1.0], [True, True]) == 0.0
    assert calibration_error([0.85, 0.85, 0.85, 0.85], [True, True, True, False]) == pytest.approx(0.1)
    mixed = calibration_error([0.95, 0.95, 0.55, 0.55], [True, False, True, True])
    assert mixed == pytest.approx((2 * 0.45 + 2 * 0.45) / 4)


@pytest.fixture
def children(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Instead of child processes: big-M dies, the rest answers at once; `asked` counts calls by what was asked."""

    class Children(PlantedChild):
        asked = dict.fromkeys(("search", "paper", "plan"), 0)

        def call(self, limit_s: float, **request: Any) -> dict[str, Any]:
            if "tasks" in request:
                Children.asked["plan"] += 1
                rows = [planned(**task, picked="walking") for task in request["tasks"]]
                times = {"load_s": 0.01, "warm_up_s": 0.3, "warm_up_plans": 2}
                return {"rows": rows, "select_us": [12.0] * len(rows)} | times
            if "method" not in request:
                Children.asked["search"] += 1
                return searched() | {"costs": {}, "status": "solved"}
            Children.asked["paper"] += 1
            if request["method"] == "bigm_random":
                raise Lost("crashed: SIGABRT", 9.0, 10.0)
            return calls(0.003, 1.0)[request["method"]]

    monkeypatch.setattr(child, "Child", Children)
    monkeypatch.setattr(online, "REFERENCES", 3)
    monkeypatch.setattr(online, "PAPER_TASKS", 2)
    return Children


def test_only_plan_is_timed_again_and_a_lost_solver_is_a_failed_run(
    pristine: Path, tmp_path: Path, children: Any
) -> None:
    scenario = scenario_of(pristine)
    done = run(scenario, pristine, tasks=5, runs=tmp_path)
    assert children.asked == {"search": 3, "paper": 8, "plan": 1}
    again = run(scenario, pristine, tasks=5, runs=tmp_path)
    assert children.asked == {"search": 3, "paper": 8, "plan": 2}
    assert again["rows"] == done["rows"]
    assert (done["bench"], done["scenario"], len(done["rows"])) == ("online", scenario.name, 5)
    big_m = done["summary"]["methods"]["bigm_random"]
    assert (big_m["successful"], big_m["optimal"], big_m["time_median_s"]) == (0, 0, 9.0)
    assert done["summary"]["speedup_vs_paper_median"] == 3000.0
    assert done["summary"]["map_version"] == "1.0.0"
    targets = done["summary"]["targets"]
    assert (targets["tasks"]["found"], targets["tasks"]["meets"]) == (5, False)
    assert (targets["plan_ms_p50"]["at_most"], targets["plan_ms_p50"]["meets"]) == (5.0, True)
    for row in done["rows"]:
        assert row["violation"] == 1.23457e-9
        assert row["speed"] == round(row["speed"], 6)
        assert row["picked"] == "walking"
    json.dumps(done, allow_nan=False)


def test_a_thousand_rows_stay_small(pristine: Path, tmp_path: Path, children: Any) -> None:
    done = run(scenario_of(pristine), pristine, tasks=1000, runs=tmp_path)
    assert len(json.dumps(done, indent=1)) < 400_000


def test_the_command_writes_document_and_figure(
    pristine: Path, tmp_path: Path, checkout: Path, children: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = run(scenario_of(pristine), pristine, tasks=5, runs=tmp_path / "runs")
    monkeypatch.setattr(measure, "measure", lambda *arguments: done)
    (tmp_path / "configs").symlink_to(checkout / "configs")
    arguments = ["--root", str(tmp_path), "bench", "online", "--scenario", "quickstart"]
    told = CliRunner().invoke(main, arguments)
    assert told.exit_code == 0, told.output
    files = [tmp_path / "docs/results" / f"online-quickstart.{kind}" for kind in ("json", "png")]
    assert told.stdout.splitlines()[-2:] == [str(path) for path in files]
    assert json.loads(files[0].read_bytes())["summary"] == done["summary"]
    assert files[1].read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_real_map_from_references_to_targets(pristine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(online, "REFERENCES", 2)
    monkeypatch.setattr(online, "PAPER_TASKS", 2)
    told = run(scenario_of(pristine), pristine, tasks=4, runs=tmp_path)["summary"]
    assert (told["tasks"], told["feasible_rate"], told["consistent_tasks"]) == (4, 1.0, 2)
    assert told["methods"]["plan"]["successful"] == 2
    assert told["speedup_vs_paper_median"] > 1
