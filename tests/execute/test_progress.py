from __future__ import annotations

import io
import re

import pytest
from rich.console import Console

from gaitflow.execute import progress as module
from gaitflow.execute.progress import describe, progress
from gaitflow.execute.run import RunState


def test_time_left_is_estimated_from_this_run_only() -> None:
    assert describe(RunState(total=20, found=10, solved=10, failed=0), 5.0) == "10 solved, 0 failed, 10 left"
    state = RunState(total=20, found=10, solved=13, failed=2)
    assert describe(state, 60.0) == "13 solved, 2 failed, 5 left, 0:01:00 to go"
    assert describe(RunState(total=3, found=0, solved=3, failed=0), 9.0) == "3 solved, 0 failed, 0 left"


def test_plain_lines_when_not_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "LINE_EVERY_S", 0.05)
    out = io.StringIO()
    with progress("map [x]", Console(file=out, width=40)) as on_event:
        on_event(RunState(10, 0, 1, 0))
        while "1 solved" not in out.getvalue():
            pass
        on_event(RunState(10, 0, 9, 1, ("unit [ab]: crashed: SIGSEGV",)))
    lines = out.getvalue().splitlines()
    assert "unit [ab]: crashed: SIGSEGV" in lines
    assert re.fullmatch(r"map \[x\]: 9 solved, 1 failed, 0 left, 0:00:0\d elapsed", lines[-1])
    assert "\x1b" not in out.getvalue()


def test_a_bar_on_a_terminal() -> None:
    out = io.StringIO()
    with progress("map [x]", Console(file=out, force_terminal=True, width=100)) as on_event:
        on_event(RunState(4, 0, 2, 0, ("unit [ab]: hung",)))
    assert "map [x]" in out.getvalue() and "2 solved, 0 failed, 2 left" in out.getvalue()
    assert "unit [ab]: hung" in out.getvalue()
