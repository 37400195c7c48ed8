"""Bench cpp: every task is planned by both, and compared; needs cmake, cc and g++."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.document import plain
from benchmarks.online import cpp


@pytest.mark.slow
def test_both_plan_the_same_tasks(pristine: Path) -> None:
    done = cpp.run(pristine, tasks=20)
    summary = done["summary"]
    assert done["bench"] == "cpp" and done["rows"] == plain(done["rows"])
    assert summary["tasks"] == len(done["rows"]) == 20
    assert summary["same_plan"] == 20 - summary["by_ipopt"]
    assert summary["cost_error_max"] <= cpp.SAME_COST
    assert summary["speedup_median"] > 1 and summary["build_s"] > 0


def test_a_program_that_fails_is_named() -> None:
    with pytest.raises(RuntimeError, match="false"):
        cpp.run_program(["false"])


def test_a_program_answers_line_by_line_and_is_named_when_it_ends() -> None:
    program = cpp.AskedInTurn(["cat"])
    assert [program(f'{{"cost": {cost}}}\n') for cost in (1, 2)] == [{"cost": 1}, {"cost": 2}]
    program = cpp.AskedInTurn(["false"])
    for _ in range(2):
        with pytest.raises(RuntimeError, match="false: ended with code 1"):
            program("0.9 0.6\n")
