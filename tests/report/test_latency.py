from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes

from gaitflow.report.latency import NAMES, draw_latency


def row(wall_ms: float, path: str = "fast") -> dict[str, Any]:
    parts = {"select_ms": 0.1, "predict_ms": 0.3, "refine_ms": wall_ms - 0.5}
    return {"wall_ms": wall_ms, "cpu_ms": 0.9 * wall_ms, "path": path, **parts}


def calls(big_m: str) -> dict[str, Any]:
    found = {name: {"status": "solved", "cpu_s": 0.04} for name in NAMES}
    return found | {"bigm_random": {"status": big_m, "cpu_s": 2.0}}


@pytest.fixture
def document() -> dict[str, Any]:
    rows = [row(3.0), row(4.0), row(5.0), row(60.0, "fallback")]
    for each, status in zip(rows, ("solved", "failed", "failed"), strict=False):
        each["paper"] = calls(status)
    quantiles = dict(zip(("p50", "p95", "p99", "max"), (4.0, 30.0, 50.0, 60.0), strict=True))
    summary = {f"plan_{clock}ms_{name}": value for clock in ("", "cpu_") for name, value in quantiles.items()}
    summary["targets"] = {"plan_ms_p50": {"at_most": 7.0}, "plan_ms_p99": {"at_most": 20.0}}
    summary["methods"] = {name: {"time_median_s": 0.04, "optimal": 2, "runs": 3} for name in NAMES}
    summary["methods"]["bigm_random"] |= {"time_median_s": 2.0, "optimal": 1}
    summary["speedup"] = {name: {"median": 321.0} for name in NAMES if name != "plan"}
    return {"scenario": "half-cheetah", "rows": rows, "summary": summary}


def legend(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_every_call_is_in_the_histogram_with_quantiles_and_targets(document: dict[str, Any]) -> None:
    histogram, _, _ = draw_latency(document).axes
    assert sum(bar.get_height() for bar in histogram.patches if hasattr(bar, "get_height")) == 4
    upright = [float(np.asarray(line.get_xdata())[0]) for line in histogram.lines if line.get_marker() == "None"]
    assert upright == [4.0, 30.0, 50.0, 60.0]
    marked = {line.get_marker(): np.atleast_1d(line.get_xdata()).tolist() for line in histogram.lines}
    assert (marked["v"], marked["D"], marked["x"]) == ([7.0], [20.0], [60.0])
    told = legend(histogram)
    assert "p99  50 ms, CPU 50" in told
    assert "target of p50  7 ms" in told
    assert "not on the fast path  1" in told
    low, high = histogram.get_xlim()
    assert low < 2.7 and high > 60.0


def test_without_a_slow_path_none_is_told(document: dict[str, Any]) -> None:
    document["rows"] = document["rows"][:3]
    assert not any("not on" in text for text in legend(draw_latency(document).axes[0]))


def test_parts_have_their_medians(document: dict[str, Any]) -> None:
    _, parts, _ = draw_latency(document).axes
    medians = [float(np.asarray(line.get_xdata())[0]) for line in parts.lines if line.get_marker() == "|"]
    assert medians == pytest.approx([0.1, 0.3, 4.0])
    assert [label.get_text() for label in parts.get_yticklabels()] == ["select", "predict", "refine"]


def test_methods_have_a_dot_a_task_and_a_cross_a_failure(document: dict[str, Any]) -> None:
    methods = draw_latency(document).axes[2]
    drawn = {mark: [line for line in methods.lines if line.get_marker() == mark] for mark in "ox"}
    assert [len(np.asarray(line.get_xdata())) for line in drawn["o"]] == [3, 3, 3, 1]
    assert [len(np.asarray(line.get_xdata())) for line in drawn["x"]] == [0, 0, 0, 2]
    assert np.asarray(drawn["x"][-1].get_xdata()).tolist() == [2000.0, 2000.0]
    told = [text.get_text() for text in methods.texts]
    assert told[0] == "40 ms\nbest cost on 2 of 3"
    assert told[-1] == "2 s, 321 × plan()\nbest cost on 1 of 3"


def test_a_document_without_the_papers_way_leaves_its_place_empty(document: dict[str, Any]) -> None:
    document["rows"] = [row(3.0)]
    assert not draw_latency(document).axes[2].axison


def test_no_task_at_all_is_refused(document: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="no task"):
        draw_latency(document | {"rows": []})
