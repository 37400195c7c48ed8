"""The report's section on how a map chose its tasks."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gaitflow.certificate.certificate import Certificate
from gaitflow.config.sampling import Sampling
from gaitflow.report.certificate import SamplingRecord, certificate_in_words, rounds_table
from gaitflow.report.report import PAGE, write_report

GOOD = Certificate(
    searched=300, dearer=2, dearer_bound=0.0199, planned=1200, infeasible=1, infeasible_bound=0.0049, cheaper=4,
    worst_excess=0.031, asking=3, seed=0,
)  # fmt: skip


def one(kind: str, tasks: int, searched: int, wrong: int, certificate: Certificate | None = None) -> dict:
    bounds = (None, None) if certificate is None else (certificate.dearer_bound, certificate.infeasible_bound)
    return {
        "kind": kind, "tasks": tasks, "searched": searched, "wrong": wrong, "gaits": 6, "inside": 0.9,
        "dearer_bound": bounds[0], "infeasible_bound": bounds[1],
    }  # fmt: skip


ROUNDS = [one("start", 32, 32, 0), one("doubt", 16, 48, 3), one("certificate", 300, 348, 2, GOOD)]


def test_the_statement_says_what_was_asked_and_how_sure_it_is() -> None:
    chosen, statement = certificate_in_words(SamplingRecord(GOOD.as_data(), ROUNDS), Sampling())
    assert "the 348 tasks that were searched, in 3 rounds" in chosen
    assert statement.startswith("With 95% confidence at most 1.99 % of the domain's tasks get a pick")
    assert "more than 1 % dearer" in statement and "at most 0.49 % one without a motion" in statement
    assert "300 random tasks" in statement and "2 picks were dearer" in statement and "by 3.1 %" in statement
    assert "4 cheaper" in statement and "1200 were planned: at 1 no motion was found" in statement
    assert "certificates were tried 3 times" in statement


def test_a_certificate_of_plans_tells_of_selections_too() -> None:
    found = replace(GOOD, selected_dearer=9, selected_bound=0.06)
    _, statement, of_selections = certificate_in_words(SamplingRecord(found.as_data(), ROUNDS), Sampling())
    assert "get a plan that is more than 1 % dearer" in statement and "at most 0.49 % none" in statement
    assert "2 plans were dearer" in statement
    assert "At 9 of the searched tasks" in of_selections and "at most at 6 % of the domain's tasks" in of_selections


@pytest.mark.parametrize(
    ("certificate", "fault"),
    [
        (None, "no certificate of the map as it is: tasks.sampling.most = 1000 left"),
        (GOOD.as_data() | {"dearer_bound": 0.08}, "0.08, more than tasks.sampling.dearer = 0.02"),
    ],
)
def test_what_misses_the_goal_is_told(certificate, fault) -> None:
    *_, last = certificate_in_words(SamplingRecord(certificate, ROUNDS[:2]), Sampling())
    assert last.startswith("Short of the scenario's goal: ") and fault in last


def test_what_trained_the_classifier_of_a_good_certificate_is_no_fault() -> None:
    told = certificate_in_words(SamplingRecord(replace(GOOD, learning="abc").as_data(), ROUNDS), Sampling())
    assert not any("Short of" in each for each in told)


def test_every_round_is_a_row() -> None:
    assert rounds_table(SamplingRecord(GOOD.as_data(), ROUNDS)).rows == (
        ("1", "spread over the box", "32", "32", "–", "6", "–", "–"),
        ("2", "where the map was unsure", "16", "48", "3", "6", "–", "–"),
        ("3", "random, for a certificate", "300", "348", "2", "6", "1.99 %", "0.49 %"),
    )


def test_the_report_of_a_map_that_chose_its_tasks(
    tmp_path, turning, turning_labels, gaits, turning_select, record
) -> None:
    sampling = SamplingRecord(GOOD.as_data(), ROUNDS)
    write_report(tmp_path, turning, turning_labels, [], gaits, turning_select, None, record, sampling)
    html = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "<h2>Certificate</h2>" in html and "<td>where the map was unsure</td>" in html
    assert "<b>300</b><span>searched tasks</span>" in html and "<b>60</b><span>held-out tasks</span>" in html
    assert "<b>1.99 %</b><span>answers too dear, at most</span>" in html
    assert "<th>searched tasks</th><th>held-out tasks</th>" in html
    assert "9 of 20 slices of the map are drawn" in html and "Each task is drawn in the slice nearest to it." in html
    assert "chosen by the map, anywhere with speed from 0.1 to 2.3 m/s, lateral speed from -0.4 to 0.4 m/s" in html
    assert "grid task" not in html


def test_the_report_of_a_grid_has_no_such_section(tmp_path, scenario, labels, record) -> None:
    write_report(tmp_path, scenario, labels, [], [], None, None, record)
    html = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "<h2>Certificate</h2>" not in html and "<b>84</b><span>grid tasks</span>" in html
