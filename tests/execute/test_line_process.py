"""The one protocol of processes that may crash or hang, without a solver in it."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator

import pytest

from gaitflow.execute.line_process import LineProcess, Lost


@pytest.fixture
def child() -> Iterator[LineProcess]:
    process = LineProcess("answering", [])
    yield process
    process.end()


def test_an_answer_of_any_length_comes_from_one_thread_in_a_session_of_its_own(child: LineProcess) -> None:
    answer = child.ask({"do": "nothing"}, 30)
    assert answer["threads"] == "1" and answer["session"] == child.pid != os.getsid(0)
    assert len(answer["padding"]) == 200_000 and child.alive


def test_what_prints_is_no_answer_and_is_kept_until_the_next_request(child: LineProcess) -> None:
    child.ask({"do": "say", "text": "a solver's chatter"}, 30)
    assert child.said() == ["a solver's chatter", "and from C"]
    child.ask({"do": "say", "text": "more"}, 30)
    assert child.said() == ["more", "and from C"]


@pytest.mark.parametrize(
    ("request_", "ending"),
    [
        ({"do": "kill", "signal": signal.SIGSEGV}, "crashed: SIGSEGV"),
        ({"do": "kill", "signal": signal.SIGKILL}, "crashed: SIGKILL"),
        ({"do": "exit", "code": 3}, "exited with code 3"),
    ],
)
def test_what_ended_a_child_is_told(child: LineProcess, request_: dict[str, object], ending: str) -> None:
    with pytest.raises(Lost, match=r"^$"):
        child.ask(request_, 30)
    assert child.end() == ending and not child.alive
    if request_["do"] == "exit":
        assert child.said() == ["a last word"]


def test_a_hang_is_not_waited_for(child: LineProcess) -> None:
    child.ask({"do": "nothing"}, 30)
    begin = time.monotonic()
    with pytest.raises(Lost, match="hung: no answer in 1 s"):
        child.ask({"do": "sleep", "seconds": 600}, 0.6)
    assert time.monotonic() - begin < 10
    assert child.end() == "stopped answering"


def test_another_thread_may_end_it(child: LineProcess) -> None:
    child.ask({"do": "nothing"}, 30)
    threading.Timer(0.3, child.terminate, [5.0]).start()
    with pytest.raises(Lost, match=r"^$"):
        child.ask({"do": "sleep", "seconds": 600}, 60)
    assert child.end() == "crashed: SIGTERM"
