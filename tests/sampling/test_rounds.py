"""Rounds are written down and read back; only a certificate that nothing was learnt from is held out."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from gaitflow.certificate.certificate import certify
from gaitflow.certificate.judge import Verdict
from gaitflow.core.task_space import TaskSpace
from gaitflow.sampling.rounds import Kind, Round, askings, held_out, rounds_from, task_at, was_stopped

SPACE = TaskSpace(("speed", "slope"), (("cycle_duration", 0.5),))
CERTIFICATE = certify([Verdict(task_at(SPACE, (0.3, 3.0)), "", "", 0.0)] * 9, [], [True], 1, 0)


def a_round(kind: Kind, *speeds: float) -> Round:
    return Round(kind, tuple(task_at(SPACE, (speed, 3.0)) for speed in speeds))


def test_rounds_come_back_as_they_were() -> None:
    known = Round("known", a_round("start", 0.4).tasks, askings=2)
    rounds = [known, a_round("start", 0.1, 0.2), Round("certificate", a_round("start", 0.3).tasks, CERTIFICATE)]
    data = json.loads(json.dumps([one.as_data(SPACE) for one in rounds]))
    assert rounds_from(data, SPACE) == rounds
    assert askings(rounds) == 3, "those before the dataset was published count"
    assert askings([a_round("start", 0.1), a_round("certificate", 0.3)]) == 0, "not answered yet"


def test_a_certificate_comes_back_with_what_trained_its_classifier() -> None:
    asked = replace(CERTIFICATE, learning="abc")
    assert "learning" not in CERTIFICATE.as_data() and asked.as_data()["learning"] == "abc"
    data = json.loads(json.dumps([replace(a_round("certificate", 0.3), certificate=asked).as_data(SPACE)]))
    assert rounds_from(data, SPACE)[0].certificate == asked


def test_askings_cannot_be_taken_back() -> None:
    with pytest.raises(ValueError, match="askings = -3"):
        Round("known", (), askings=-3)
    with pytest.raises(ValueError, match="askings = -3"):
        rounds_from([{"kind": "known", "tasks": [], "askings": -3}], SPACE)


@pytest.mark.parametrize(
    "data",
    [
        7,
        [{"kind": "start"}],
        [{"kind": "x", "tasks": []}],
        [{"kind": "start", "tasks": [[1]]}],
        [{"kind": "certificate", "tasks": [], "certificate": {"searched": 1, "luck": 7}}],
        [{"kind": "certificate", "tasks": [], "certificate": None}],
    ],
)
def test_anything_else_is_one_line(data: Any) -> None:
    with pytest.raises(ValueError, match="no rounds of a sampling over speed, slope"):
        rounds_from(data, SPACE)


def test_held_out_is_the_last_certificate_with_its_further_tasks() -> None:
    start, first, more = a_round("start", 0.1), a_round("certificate", 0.2), a_round("more", 0.3)
    assert held_out([start]) == set() == held_out([a_round("known", 0.0)])
    assert held_out([start, first, more]) == {*first.tasks, *more.tasks}
    assert held_out([start, first, a_round("certificate", 0.4)]) == set(a_round("certificate", 0.4).tasks)
    assert held_out([start, first, more, a_round("doubt", 0.5)]) == set()


def test_a_sampling_was_stopped_in_a_round_with_tasks_to_search_or_a_certificate_to_ask() -> None:
    start, asked = a_round("start", 0.1, 0.2), a_round("certificate", 0.3)
    searched = {*start.tasks, *asked.tasks}
    assert not was_stopped([], searched)
    assert was_stopped([start], start.tasks[:1]) and not was_stopped([start], searched)
    assert was_stopped([start, asked], start.tasks) and was_stopped([start, asked], searched)
    assert not was_stopped([start, replace(asked, certificate=CERTIFICATE)], searched)
