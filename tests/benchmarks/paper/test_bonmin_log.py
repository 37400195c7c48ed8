"""The logs in tests/data/bonmin are Bonmin's own, of the planar robot at 2.0 m/s (whole) and 1.3 m/s (time limit)."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.paper.bonmin_log import Incumbent, read_log


@pytest.fixture
def logs(checkout: Path) -> dict[str, str]:
    return {path.stem: path.read_text(encoding="utf-8") for path in (checkout / "tests/data/bonmin").glob("*.txt")}


def test_a_completed_run_has_no_gap(logs: dict[str, str]) -> None:
    log = read_log(logs["completed"])
    assert log.incumbents == (
        Incumbent(0.06, 0.64970789, 0, "FPump"),
        Incumbent(0.94, 0.60069715, 19, "tree"),
        Incumbent(1.52, 0.5804484, 38, "tree"),
    )
    assert log.completed
    assert log.best == log.bound == 0.580448398776211, "as printed at the end, with all digits"
    assert log.gap == 0.0
    assert (log.nodes, log.time_s, log.relaxation) == (60, 1.87, 0.3)


def test_a_stopped_run_has_a_bound_and_a_gap(logs: dict[str, str]) -> None:
    log = read_log(logs["stopped"])
    assert not log.completed
    assert (log.best, log.bound, log.nodes, log.time_s) == (0.46027175, 0.3, 0, 0.57)
    assert log.gap == pytest.approx((0.46027175 - 0.3) / 0.46027175)
    assert (log.programs, log.failed_programs) == (17, 0)


def test_a_killed_run_tells_what_it_had_found(logs: dict[str, str]) -> None:
    text = logs["completed"]
    log = read_log(text[: text.index("After 25 nodes") + len("After 25 nodes, 1 on")])
    assert not log.completed
    assert [each.objective for each in log.incumbents] == [0.64970789, 0.60069715]
    assert (log.best, log.nodes) == (0.60069715, 24), "the line that was cut off does not count"
    assert log.bound is not None and 0.3 <= log.bound < log.best
    early = read_log(text[: text.index("Cbc0012I")])
    assert (early.best, early.bound, early.gap, early.incumbents) == (None, None, None, ())
    assert early.relaxation == 0.3


def test_nothing_found_and_nothing_solved() -> None:
    log = read_log(
        "NLP0014I             1      FAILED 0.73880787      150 0.084451\n"
        "Cbc0010I After 3 nodes, 1 on tree, 1e+50 best solution, best possible -1.7976931e+308 (30.50 seconds)\n"
        "Cbc0005I Partial search - best objective 1e+50 (best possible 0.25), took 36 iterations and 5 nodes "
        "(80.50 seconds)\n"
    )
    assert (log.best, log.bound, log.gap, log.relaxation) == (None, 0.25, None, None)
    assert (log.programs, log.failed_programs, log.nodes) == (1, 1, 5)
    assert read_log("").time_s is None
    assert read_log("Segmentation fault").incumbents == ()


def test_an_incumbent_that_is_no_improvement_is_left_out() -> None:
    line = "Cbc0004I Integer solution of {} found after {} iterations and {} nodes ({} seconds)\n"
    log = read_log(line.format(0.5, 9, 1, 1.5) + line.format(0.5, 10, 2, 1.75) + line.format(0.25, 11, 3, 2.0))
    assert [(each.objective, each.time_s) for each in log.incumbents] == [(0.5, 1.5), (0.25, 2.0)]
