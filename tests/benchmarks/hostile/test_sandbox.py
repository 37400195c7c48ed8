from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from benchmarks.hostile import sandbox
from benchmarks.hostile.bench import _watched
from benchmarks.hostile.sandbox import Outcome, Unsound, ask


def raises(error: BaseException) -> Callable[[], Any]:
    def question() -> Any:
        raise error

    return question


def endless() -> Any:
    while True:
        pass


def greedy() -> Any:
    return len(bytearray(1 << 40))


@pytest.mark.parametrize(
    ("question", "verdict"),
    [
        (lambda: [1, None], "same answer"),
        (raises(ValueError("f.yaml: mass = -1: must be positive")), "refused"),
        (raises(ValueError("")), "unsound"),
        (raises(ValueError("much\n" * 100)), "unsound"),
        (raises(Unsound("a number is not finite")), "unsound"),
        (raises(KeyError("gait")), "traceback"),
        (raises(SystemExit(0)), "traceback"),
        (lambda: os.kill(os.getpid(), signal.SIGKILL), "crash"),
        (lambda: os._exit(0), "crash"),
        (greedy, "memory"),
        (raises(ValueError("f.yaml: '\x1b[31m' is no number")), "unsound"),
        (endless, "hang"),
    ],
)
def test_what_becomes_of_a_question(question: Callable[[], Any], verdict: str) -> None:
    assert ask(question, (ValueError,), cpu_s=1).verdict == verdict


def test_much_memory_is_a_fault_though_it_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sandbox, "RESIDENT", 1 << 26)
    assert ask(lambda: len(b"x" * (1 << 27)), ()).verdict == "memory"
    assert ask(lambda: len(b"x" * (1 << 24)), ()).verdict == "same answer"


def test_an_answer_is_compared_with_the_undamaged_file_s() -> None:
    original = ask(lambda: [1.5], ())
    assert ask(lambda: [1.5], ()).beside(original).verdict == "same answer"
    assert ask(lambda: [1.6], ()).beside(original) == Outcome("another answer", [1.6])


def test_a_file_that_was_read_beside_the_folder_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "secret").write_bytes(b"secret")
    with _watched(tmp_path) as was_touched:
        ask(lambda: os.listdir(tmp_path), ())
    assert not was_touched()
    with _watched(tmp_path) as was_touched:
        ask(lambda: (tmp_path / "secret").read_text(), ())
    assert was_touched()


def test_a_file_that_was_written_where_a_process_runs_is_noticed(tmp_path: Path) -> None:
    with _watched(tmp_path) as was_touched:
        ask(lambda: Path("made").write_text("x"), (), within=tmp_path)
    assert was_touched()
