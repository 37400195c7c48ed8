from __future__ import annotations

import json
import time

import pytest

from benchmarks.child import Child, ChildError, Lost, answers_of

pytestmark = pytest.mark.usefixtures("bench_factories")


def test_one_process_with_one_thread_serves_all_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    with Child("factories:Worker", {"offset": 10}) as child:
        assert child.call(30, do="add", value=1) == {"value": 11, "calls": 1, "threads": "1"}
        assert child.call(30, do="print", value=2)["value"] == 12
        assert child.call(30, do="add")["calls"] == 3


def test_a_crash_costs_one_call_and_its_cpu_time_is_known() -> None:
    with Child("factories:Worker", {"offset": 0}) as child:
        child.call(30, do="add")
        with pytest.raises(Lost, match="crashed: SIGSEGV") as lost:
            child.call(30, do="burn")
        assert 0.2 < lost.value.cpu_s < 5, "the 0.3 s of this call, not the process's start"
        assert child.call(30, do="add")["calls"] == 1, "a new process took over"


def test_an_exit_and_a_hang_are_losses() -> None:
    with Child("factories:Worker", {"offset": 0}) as child:
        with pytest.raises(Lost, match="exited with code 3"):
            child.call(30, do="exit")
        child.call(30, do="add")
        start = time.monotonic()
        with pytest.raises(Lost, match=r"hung: no answer in 1 s") as lost:
            child.call(0.6, do="hang")
        assert time.monotonic() - start < 20
        assert lost.value.wall_s >= 0.6


def test_an_exception_is_no_loss_but_an_error_of_ours() -> None:
    with Child("factories:Worker", {"offset": 0}) as child, pytest.raises(ChildError, match="no such gait"):
        child.call(30, do="raise")
    with Child("factories:Worker", {"of": 0}) as child, pytest.raises(ChildError, match="unexpected keyword"):
        child.call(30, do="add")
    with Child("factories:Nothing", {}) as child, pytest.raises(ChildError, match="Nothing"):
        child.call(30, do="add")


def test_every_answer_tells_the_cpu_time() -> None:
    assert "error" in json.loads(answers_of("builtins:sorted")({"iterable": [3, 1, 2]}))
    told = json.loads(answers_of("builtins:complex")({"real": 2.5}))
    assert told["result"] is None
    assert told["cpu_s"] > 0
