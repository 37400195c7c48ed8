"""What the page of a report says: the numbers at its top, and its sections."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from gaitflow.config.scenario import Scenario
from gaitflow.report.certificate import SamplingRecord, certificate_in_words, rounds_table
from gaitflow.report.map_tasks import map_task_words, of_map
from gaitflow.report.page import Picture, Section
from gaitflow.report.scenario_text import scenario_text
from gaitflow.report.slices import slices_of
from gaitflow.report.tables import (
    Table,
    between_knots_table,
    check_table,
    effort_table,
    gait_table,
    learning_table,
    percent,
    provenance_table,
    refined,
    tie_table,
    unresolved_table,
    unsolved_table,
)
from gaitflow.search.solution import Solution

ALONE = "Drawn from the map alone: tasks, costs and margins are what it predicts on its grid."


def highlights(
    labels: pd.DataFrame, learning: Mapping[str, Any] | None, sampling: SamplingRecord | None
) -> list[tuple[str, str]]:
    """Pairs of a name and a number; the arguments as `write_report` has them."""
    solved = labels[labels["status"] == "solved"]
    pairs = [
        (f"{map_task_words(labels)}s", str(int(of_map(labels).sum()))),
        ("held-out tasks", str(int((~of_map(labels)).sum()))),
        ("gaits that win somewhere", str(solved["gait"].nunique())),
        ("tasks without a gait", str(len(labels) - len(solved))),
        ("tasks with ties", str(int((labels["ties"].map(len) > 1).sum()))),
    ]
    if refined(labels):
        pairs += [("labels not resolved", str(int((~solved["resolved"].astype(bool)).sum())))]
    if learning is not None:
        quality = next(one for one in learning["competitors"] if one["method"] == learning["method"])
        judged = quality["held_out"] if quality["held_out"]["tasks"] else quality["cross_validation"]
        pairs += [("classifier published", learning["method"]), ("mean cost regret", percent(judged["regret_mean"]))]
    if sampling is not None and sampling.certificate is not None:
        pairs += [("answers too dear, at most", percent(sampling.certificate["dearer_bound"]))]
    return pairs


def sections(
    scenario: Scenario,
    labels: pd.DataFrame,
    solutions: Sequence[Solution],
    regions: Mapping[str, Sequence[Solution]],
    learning: Mapping[str, Any] | None,
    record: Mapping[str, Any] | None,
    sampling: SamplingRecord | None,
    images: Mapping[str, bytes],
    motions: Sequence[str],
) -> list[Section]:
    """The sections in their order. `regions` are the labelled motions by gait, `images` the PNGs by name.

    `motions` names those of `images` that show a motion each. The rest is as `write_report` has it; without a `record`
    there are only the sections that a map alone can fill.
    """

    def pictures(*names: str, caption: str = "") -> tuple[Picture, ...]:
        return tuple(Picture(images[name], name, caption) for name in names if name in images)

    space, data = scenario.tasks.space, scenario.as_data()
    ties, missing, unresolved = (table(labels, space) for table in (tie_table, unsolved_table, unresolved_table))
    labelled = [solution for region in regions.values() for solution in region]
    chosen = "Regions: the map's choice. Markers: the gait that costs least."
    tolerance = percent(scenario.learning.tie_tolerance)
    none = f"No task has gaits within {tolerance} of each other."
    judged = ("No classifier was trained.",)
    if learning is not None:
        numbers = "Numbers are on the cross-validation folds / on the held-out tasks; the published method is marked."
        judged = (f"How the winner is chosen: {learning['rule']}", numbers, *learning["remarks"])
    told = (ALONE,) if record is None else ()
    shown = [
        Section("The scenario", scenario_text(scenario)),
        Section(
            "Gait map",
            told,
            pictures=pictures("map", caption=f"{chosen} {slices_of(labels, scenario.tasks).remark}".strip()),
        ),
        *_certificate(scenario, sampling),
        Section(
            "Gaits",
            ("The margin is how much dearer the next best gait is.",),
            pictures("gaits", caption="When each leg stands, with the mean phase durations of the gait's tasks."),
            gait_table(labels, scenario.robot.leg_names),
        ),
    ]
    learnt = [
        Section("Classifiers", judged, table=None if learning is None else learning_table(learning)),
        Section("Ties", (f"Gaits within {tolerance} of the least cost tie." if ties.rows else none,), table=ties),
    ]
    lacking = Section(
        "Tasks without a gait",
        () if missing.rows else ("A gait was found for every task.",),
        table=missing,
    )
    if record is None:
        return [*shown, *learnt, lacking]
    return [
        *shown,
        Section(
            "State space",
            ("Trajectories of one gait look alike, which is why their mean is a good start for an optimiser.",),
            pictures("state_space", caption="A line a task; bold is the mean of the gait's most common pattern."),
        ),
        Section(
            "Motions",
            ("The task nearest the middle of each region. Red arrows are contact forces.",),
            pictures(*motions),
        ),
        *learnt,
        Section(
            "Labels that the mesh leaves open",
            (_on_resolution(labels, unresolved),),
            table=unresolved,
        ),
        lacking,
        Section(
            "Every label checked again",
            (
                f"{len(labelled)} of {int((labels['status'] == 'solved').sum())} labelled motions, each judged anew by "
                "an integrator and constraints that share no code with the solver's problem; values are scaled: forces "
                "by the robot's weight, lengths by a metre, times by the cycle.",
            ),
            table=check_table(data, labelled),
        ),
        Section(
            "Between the knots",
            (
                "The same motions on a grid ten times finer: how far the stored states are from the continuous motion "
                "under the same forces [m or rad], and the constraints that no knot sees (friction over the robot's "
                "weight, the others in m).",
            ),
            table=between_knots_table(data, labelled),
        ),
        Section("Solves", table=effort_table(solutions)),
        Section("Provenance", table=provenance_table(record)),
    ]


def _certificate(scenario: Scenario, sampling: SamplingRecord | None) -> tuple[Section, ...]:
    goal = scenario.tasks.adaptive
    if sampling is None or goal is None:
        return ()
    return (Section("Certificate", certificate_in_words(sampling, goal), table=rounds_table(sampling)),)


def _on_resolution(labels: pd.DataFrame, unresolved: Table) -> str:
    if not refined(labels):
        return "The costs were not compared with those on a finer mesh."
    if unresolved.rows:
        return "The margin is smaller than the error that a finer mesh shows, or none was asked; the gaits do not tie."
    return "Every margin is larger than the errors of the costs behind it, by a finer mesh, or the gaits tie."
