"""How a map chose its tasks, and what its certificate says, in words and as a table of the rounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gaitflow.config.sampling import Sampling
from gaitflow.publishing.judge_map import faults_of_certificate
from gaitflow.report.tables import Table, percent

ROUNDS = {
    "known": "of an earlier sampling",
    "start": "spread over the box",
    "doubt": "where the map was unsure",
    "certificate": "random, for a certificate",
    "more": "random, for the same certificate",
}
COLUMNS = (
    "round",
    "tasks are",
    "tasks",
    "searched so far",
    "wrong",
    "gaits known",
    "too dear, at most",
    "without a motion, at most",
)


@dataclass(frozen=True)
class SamplingRecord:
    """What a sampling came to, as plain data: its last certificate, None without one, and each round in its turn."""

    certificate: Mapping[str, Any] | None
    rounds: Sequence[Mapping[str, Any]]


def certificate_in_words(record: SamplingRecord, goal: Sampling) -> tuple[str, ...]:
    """Paragraphs: how the tasks were chosen, what the certificate says, and what of it misses the scenario's goal."""
    searched = max((one["searched"] for one in record.rounds), default=0)
    chosen = (
        f"The map chose the {searched} tasks that were searched, in {len(record.rounds)} rounds: first spread over the "
        "whole box of its axes, then where it was least sure of its pick. Once it was rarely wrong, random tasks of "
        "its domain were searched to certify it; where too many answers failed, the map was made from these, too. "
        "Wrong are answers that are too dear or have no motion: of a round the picks before the map was made from it, "
        "of a certificate among all of its tasks."
    )
    faults = faults_of_certificate(goal, record.certificate)
    return (chosen, *_statement(record.certificate), *(f"Short of the scenario's goal: {fault}." for fault in faults))


def _statement(found: Mapping[str, Any] | None) -> tuple[str, ...]:
    if found is None:
        return ()
    asked, selected = found["asking"], found.get("selected_bound")
    what, none = ("pick", "one without a motion") if selected is None else ("plan", "none")
    often = f", and hold although certificates were tried {asked} times: each had a part of the chance of error"
    return (
        f"With {found['confidence']:.0%} confidence at most {percent(found['dearer_bound'])} of the domain's tasks get "
        f"a {what} that is more than {percent(found['tolerance'])} dearer than the best gait that the search finds, "
        f"and at most {percent(found['infeasible_bound'])} {none}. {found['searched']} random tasks that the map is "
        f"not made from were searched: {found['dearer']} {what}s were dearer, the worst one by "
        f"{percent(found['worst_excess'])}, and {found['cheaper']} cheaper than what the search had found. "
        f"{found['planned']} were planned: at {found['infeasible']} no motion was found. The bounds are exact "
        f"(binomial){often if asked > 1 else ''}.",
        *(() if selected is None else (_of_selections(found),)),
    )


def _of_selections(found: Mapping[str, Any]) -> str:
    return (
        f"`select` names a gait before anything is solved. At {found['selected_dearer']} of the searched tasks that "
        f"gait is more than {percent(found['tolerance'])} dearer; with the same confidence, for this bound alone, at "
        f"most at {percent(found['selected_bound'])} of the domain's tasks. A plan tries other gaits that may be "
        "cheaper, too."
    )


def rounds_table(record: SamplingRecord) -> Table:
    """A row a round; bounds are those of the certificate that the round was searched for."""
    rows = [
        (
            str(number),
            ROUNDS[one["kind"]],
            str(one["tasks"]),
            str(one["searched"]),
            "–" if one["kind"] in ("known", "start") else str(one["wrong"]),
            str(one["gaits"]),
            percent(one["dearer_bound"]),
            percent(one["infeasible_bound"]),
        )
        for number, one in enumerate(record.rounds, start=1)
    ]
    return Table(COLUMNS, tuple(rows))
