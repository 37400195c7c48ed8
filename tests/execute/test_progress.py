from __future__ import annotations

import io
import re
import time

import pytest
from rich.console import Console

from gaitflow.execute import display as module
from gaitflow.execute.count import RunState
from gaitflow.execute.progress import countdown, describe, progress, share


def test_what_is_told_of_a_run() -> None:
    assert describe(RunState(total=20, found=10, solved=10, failed=0)) == "10 of 20 units"
    begun = RunState(total=20, found=10, solved=10, failed=0, in_work=2)
    assert describe(begun) == "10 of 20 units, 2 begun"
    told = RunState(20, 10, 13, 2, in_work=2, solves=310, solves_left=209.6, seconds_left=40.2)
    assert describe(told) == "15 of 20 units (2 failed), 310 of about 520 solves, 0:00:40 to go"
    assert describe(RunState(3, 0, 3, 0, solves=31, solves_left=0.0, seconds_left=0.0)) == "3 of 3 units"


def test_the_bar_is_of_what_was_missing_and_moves_inside_units() -> None:
    assert share(RunState(total=20, found=10, solved=10, failed=0)) == 0.0
    assert share(RunState(total=20, found=10, solved=14, failed=1)) == 0.5
    assert share(RunState(20, 10, 10, 0, in_work=2, solves=30, solves_left=90.0)) == 0.25
    assert share(RunState(3, 3, 3, 0)) == share(RunState(3, 0, 3, 0, solves=31, solves_left=0.0)) == 1.0


def test_plain_lines_when_not_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "FIRST_PAUSE_S", 0.05)
    out = io.StringIO()
    with progress("map [x]", Console(file=out, width=40)) as on_event:
        on_event(RunState(10, 0, 1, 0))
        while "1 of 10 units" not in out.getvalue():
            time.sleep(0.01)
        on_event(RunState(10, 0, 9, 1, ("unit [ab]: crashed: SIGSEGV",)))
    lines = out.getvalue().splitlines()
    assert "unit [ab]: crashed: SIGSEGV" in lines
    assert re.fullmatch(r"map \[x\]: 10 of 10 units \(1 failed\), 0:00:0\d elapsed", lines[-1])
    assert "\x1b" not in out.getvalue()


def test_plain_lines_grow_rarer_with_time() -> None:
    pauses = [module.pause_after(elapsed) for elapsed in (0.0, 60.0, 600.0, 36000.0)]
    assert pauses == [5.0, 5.0, 30.0, 60.0]


def test_a_bar_on_a_terminal() -> None:
    out = io.StringIO()
    state = RunState(999, 0, 2, 0, ("unit [ab]: hung",), solves=1234, solves_left=12345.0, seconds_left=3600.0)
    with progress("map [x]", Console(file=out, force_terminal=True, width=100)) as on_event:
        on_event(state)
    assert "map [x]" in out.getvalue() and "2 of 999 units, 1234 of about 13579 solves, 1:00:00 to go" in out.getvalue()
    assert "unit [ab]: hung" in out.getvalue()


def test_time_left_for_things_of_one_kind() -> None:
    told = []
    on_done = countdown(lambda text, share=None, notes=(): told.append((text, share)), "tests")
    on_done(1, 4)
    assert told == [("1 of about 4 tests, 0:00:00 to go", 0.25)]
