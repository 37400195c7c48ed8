"""When a map that chooses its tasks is tested and asked for a certificate, and when it goes on searching."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gaitflow.certificate.bound import tasks_of_look
from gaitflow.certificate.judge import Verdict
from gaitflow.config.scenario import load_scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.core.domain import Domain
from gaitflow.core.task import Task
from gaitflow.sampling import steps
from gaitflow.sampling.picks import Suspect
from gaitflow.sampling.planning import Planned, Planning
from gaitflow.sampling.rounds import Kind, Round, task_at
from gaitflow.sampling.steps import Steps

SCENARIO = Path(__file__).parents[2] / "configs/scenarios/anymal-exact-vibration.yaml"
EACH = 8
TASKS_OF_A_CERTIFICATE = 184


class Making:
    """A map of which every round finds as many wrong picks as it is told."""

    labelled = ("trot",)

    def __init__(self) -> None:
        self.scenario = load_scenario(SCENARIO)
        axes = {axis: values.values for axis, values in self.scenario.tasks.ranges.items()}
        self.domain = Domain(axes, np.ones(tuple(map(len, axes.values())), dtype=bool))
        self.tasks: list[Task] = []
        self.told: list[str] = []
        self.tell = self.told.append
        self.wrong = self.filled = 0
        self.planned: list[Task] = []  # further ones
        self.picked_by: list[Planning | None] = []  # what picked, for each judgement
        self.growth = SimpleNamespace(is_wide=False, grid=tuple(axes.values()))
        self.picked, self.places, self.regrets = {0}, np.array([[0.5, 0.6]]), np.zeros(1)

    def judge(self, tasks: Sequence[Task], planning: Planning | None = None) -> list[Verdict]:
        self.picked_by.append(planning)
        return [Verdict(task, "trot", "trot", 0.1 * (number < self.wrong)) for number, task in enumerate(tasks)]

    def judge_plans(self, tasks: Sequence[Task], planning: Planning) -> list[Verdict]:
        assert isinstance(planning, Plans)
        return self.judge(tasks)

    def take(self, tasks: Sequence[Task], verdicts: Sequence[Verdict]) -> None:
        self.tasks += tasks

    def fill(self) -> None:
        self.filled += 1

    def settle(self) -> int:
        return 0

    def costs_atlas(self) -> None:
        return None


class Plans:
    """A plan at each task; `made` for as many maps as were planned with."""

    made = 0

    def __init__(self, making: Making) -> None:
        Plans.made += 1
        self.making, making.planned = making, []

    def plans(self, tasks: Sequence[Task]) -> list[Planned | None]:
        self.making.planned += tasks
        return [Planned(0, 1.0) for _ in tasks]


@pytest.fixture
def making(monkeypatch: pytest.MonkeyPatch) -> Making:
    made = Making()
    monkeypatch.setattr(steps, "Picks", lambda _: made)
    monkeypatch.setattr(steps, "rehearse", lambda *_: [])
    return made


def tasks(making: Making, number: int) -> tuple[Task, ...]:
    """Tasks inside the domain that no other call has."""
    made = len(making.tasks)
    places = [(0.5 + 1e-3 * k, 0.6) for k in range(made, made + number)]
    return tuple(task_at(making.scenario.tasks.space, place) for place in places)


def begun(making: Making, known: Sequence[Task] = ()) -> Steps:
    """Steps of a map whose start was searched, or that was begun from known tasks and the start."""
    after = Steps(making, 0, Plans, "same")  # type: ignore[arg-type]
    if known:
        after.done(Round("known", tuple(known)))
    if after.next_kind(1000) == "start":
        after.done(Round("start", tuple(set(tasks_of(making.scenario)) - set(making.tasks))))
    return after


def doubt(after: Steps, making: Making, wrong: int) -> None:
    making.wrong = wrong
    after.begin("doubt")
    after.done(Round("doubt", tasks(making, EACH)))


def ask(after: Steps, making: Making, kind: Kind, wrong: int) -> int:
    making.wrong = wrong
    after.begin(kind)
    asked = after.tasks_of(kind, 1000)
    after.done(Round(kind, tuple(asked)))
    return len(asked)


def test_a_quiet_round_is_followed_by_tests_and_a_certificate(making: Making) -> None:
    after = begun(making)
    assert after.next_kind(1000) == "doubt"
    doubt(after, making, wrong=1)
    assert after.next_kind(1000) == "doubt" and making.filled == 0
    doubt(after, making, wrong=0)
    assert after.next_kind(1000) == "certificate" and making.filled == 1
    assert making.told[-1] == "doubt: 0 of 8 picks were wrong, 1 gaits"


@pytest.mark.parametrize(("is_wide", "expected"), [(False, "doubt"), (True, "certificate")])
def test_random_picks_that_lack_a_gait_lead_to_searches_but_over_many_axes(
    making: Making, monkeypatch: pytest.MonkeyPatch, is_wide: bool, expected: str
) -> None:
    monkeypatch.setattr(steps, "rehearse", lambda *_: [Suspect(tasks(making, 1)[0], frozenset({0}), infeasible=True)])
    making.growth.is_wide = is_wide
    after = begun(making)
    doubt(after, making, wrong=0)
    assert after.next_kind(1000) == expected and making.filled == 1


def test_a_missing_gait_is_searched_where_it_saves_most(making: Making, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = tasks(making, 2)
    lacking = [Suspect(first, frozenset({0}), False, {1: 0.02}), Suspect(second, frozenset({0}), False, {1: 0.04})]
    monkeypatch.setattr(steps, "rehearse", lambda *_: lacking)
    asked: list[tuple[Any, ...]] = []

    def placed(*arguments: Any) -> list[tuple[float, float]]:
        asked.append(arguments)
        return [(1.0, 0.5)] * arguments[6]

    monkeypatch.setattr(steps, "next_places", placed)
    after = begun(making)
    doubt(after, making, wrong=0)
    assert after.next_kind(1000) == "doubt"
    after.begin("doubt")
    chosen = after.tasks_of("doubt", 1000)
    assert chosen[0] == second and first not in chosen and len(chosen) == EACH
    _, _, searched, regrets, *_, number, _ = asked[-1]
    assert number == EACH - 1 and regrets.tolist() == [0.0, 0.04]
    assert searched[-1].tolist() == list(second.on(making.scenario.tasks.ranges)), "no other search is needed there"
    after.done(Round("doubt", tuple(chosen)))
    after.begin("doubt")
    assert after.tasks_of("doubt", 1000)[0] == second, "the map was prepared anew"


def test_small_rounds_that_are_never_quiet_are_not_repeated_for_ever(making: Making) -> None:
    after = begun(making)
    rounds = 0
    while after.next_kind(1000) == "doubt":
        doubt(after, making, wrong=1)
        rounds += 1
    assert EACH * (rounds - 1) < TASKS_OF_A_CERTIFICATE / 2 <= EACH * rounds


def test_earlier_askings_count(making: Making) -> None:
    after = Steps(making, 0, Plans, "same")  # type: ignore[arg-type]
    after.done(Round("known", tasks(making, 200), askings=3))
    after.done(Round("start", tuple(tasks_of(making.scenario))))
    assert after.next_kind(1000) == "certificate"
    after.begin("certificate")
    assert len(after.tasks_of("certificate", 1000)) > 1.5 * TASKS_OF_A_CERTIFICATE


def test_the_tasks_of_a_look_do_not_depend_on_what_was_seen(making: Making) -> None:
    sizes = set()
    for wrong in (1, 2, 3):
        making.tasks.clear()
        after = begun(making, tasks(making, 100))
        assert ask(after, making, "certificate", wrong) == TASKS_OF_A_CERTIFICATE
        assert after.next_kind(1000) == "more"
        sizes.add(ask(after, making, "more", 0))
    assert len(sizes) == 1
    making.tasks.clear()
    after = begun(making, tasks(making, 100))
    ask(after, making, "certificate", 4)
    assert after.next_kind(1000) == "doubt", "the map is mended first"


def test_two_dearer_picks_are_allowed_at_the_second_look(making: Making) -> None:
    after = begun(making, tasks(making, 100))
    ask(after, making, "certificate", 2)
    ask(after, making, "more", 0)
    assert after.certificate is not None and after.certificate.dearer_bound <= 0.02
    assert after.next_kind(1000) is None


@pytest.mark.parametrize("is_wide", [False, True])
def test_over_many_axes_a_certificate_judges_the_picks_of_the_planning(making: Making, is_wide: bool) -> None:
    making.growth.is_wide = is_wide
    after = begun(making, tasks(making, 100))
    ask(after, making, "certificate", 0)
    assert isinstance(making.picked_by[-1], Plans) is is_wide
    judged = len(making.picked_by)
    doubt(after, making, wrong=0)
    assert making.picked_by[judged:].count(None) == len(making.picked_by) - judged, "rounds ask for the cheapest gaits"


def test_a_map_plans_in_one_way_until_it_learns_more(making: Making) -> None:
    after, before = begun(making, tasks(making, 100)), Plans.made
    ask(after, making, "certificate", 2)
    ask(after, making, "more", 10)
    assert Plans.made == before + 1, "a classifier is trained once"
    doubt(after, making, wrong=0)
    ask(after, making, "certificate", 0)
    assert Plans.made == before + 2


def test_a_further_look_plans_what_the_ones_before_did_not(making: Making) -> None:
    after = begun(making, tasks(making, 100))
    searched = ask(after, making, "certificate", 2)
    assert after.certificate is not None and len(making.planned) == after.certificate.planned - searched
    first = list(making.planned)
    searched += ask(after, making, "more", 10)
    assert after.certificate.planned == searched + len(making.planned)
    assert making.planned[: len(first)] == first and len(set(making.planned)) == len(making.planned)


def test_a_certificate_stays_where_too_few_searches_are_left_for_another(making: Making) -> None:
    """A map that learned from more tasks is another one, and the certificate would not be of it."""
    after = begun(making, tasks(making, 100))
    ask(after, making, "certificate", 4)
    another = tasks_of_look(0, 0.02, 2)
    assert another > TASKS_OF_A_CERTIFICATE and after.next_kind(EACH + another) == "doubt"
    assert after.next_kind(EACH + another - 1) is None
    assert after.certificate is not None and after.certificate.dearer == 4


def test_a_map_that_learns_more_has_no_certificate(making: Making) -> None:
    after = begun(making, tasks(making, 100))
    ask(after, making, "certificate", 4)
    doubt(after, making, wrong=4)
    assert after.certificate is None and after.next_kind(0) is None


def test_a_map_begun_from_many_searches_is_tested_at_once(making: Making) -> None:
    few = begun(making, tasks(making, 8))
    assert few.next_kind(1000) == "doubt"
    making.tasks.clear()
    assert begun(making, tasks(making, 100)).next_kind(1000) == "certificate"
    making.tasks.clear()
    assert begun(making, tasks_of(making.scenario)).next_kind(1000) == "doubt", "those of the start do not count"


def test_a_map_is_not_tested_before_its_start_is_searched(making: Making, monkeypatch: pytest.MonkeyPatch) -> None:
    lacking = [Suspect(tasks(making, 1)[0], frozenset({0}), infeasible=True)]
    monkeypatch.setattr(steps, "rehearse", lambda *_: lacking)
    after = Steps(making, 0, Plans, "same")  # type: ignore[arg-type]
    after.done(Round("known", tasks(making, 100)))
    assert after.next_kind(1000) == "start"
    after.begin("start")
    assert making.filled == 0
    after.done(Round("start", tuple(after.tasks_of("start", 1000))))
    assert after.next_kind(1000) == "doubt" and making.filled == 1, "gaits that the tests miss are looked for"


def test_a_certificate_of_another_classifier_is_asked_again_of_the_same_tasks(making: Making) -> None:
    making.growth.is_wide = True
    after = Steps(making, 0, Plans, "before")  # type: ignore[arg-type]
    after.done(Round("known", tasks(making, 200)))
    after.done(Round("start", tuple(set(tasks_of(making.scenario)) - set(making.tasks))))
    making.wrong = 0
    after.begin("certificate")
    asked = after.done(Round("certificate", tuple(after.tasks_of("certificate", 1000))))
    assert after.next_kind(1000) is None

    making.tasks.clear()
    again = Steps(making, 0, Plans, "after")  # type: ignore[arg-type]
    again.done(Round("known", tasks(making, 200)))
    again.done(Round("start", tuple(set(tasks_of(making.scenario)) - set(making.tasks))))
    again.begin("certificate")
    again.done(asked)
    further = tasks_of_look(0, 0.02, 2) - TASKS_OF_A_CERTIFICATE
    assert again.next_kind(further) == "more" and again.next_kind(further - 1) is None
    assert ask(again, making, "more", 0) == further
    found = again.certificate
    assert found is not None and (found.asking, found.learning) == (2, "after")
    assert found.searched == TASKS_OF_A_CERTIFICATE + further and found.dearer_bound <= 0.02
    assert again.next_kind(1000) is None


def test_what_an_asking_came_to_is_read_and_not_judged_again(making: Making) -> None:
    after = begun(making, tasks(making, 100))
    making.wrong = 2
    after.begin("certificate")
    asked = after.done(Round("certificate", tuple(after.tasks_of("certificate", 1000))))
    making.tasks.clear()
    again = begun(making, tasks(making, 100))
    making.wrong = 0  # as if plans were made by newer code
    again.begin("certificate")
    assert again.done(asked) == asked and again.certificate == after.certificate
    assert again.next_kind(1000) == "more"
    making.wrong = 1
    assert ask(again, making, "more", 1) and again.certificate is not None
    assert again.certificate.dearer == 1, "a further look judges all tasks"
    assert again.certificate.searched > TASKS_OF_A_CERTIFICATE
