"""What making a map took, and whether every label of it stands: read from a finished run, nothing is solved again.

Wall time comes from the run's journal, from the first solve to the last stored part with pauses between sessions left
out; every stored motion is judged anew by `gaitflow.core.check`, whatever its row says.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from benchmarks.document import document
from gaitflow.config.scenario import Scenario
from gaitflow.core.check import violations
from gaitflow.dataset.gaps import GAP, motion_checks
from gaitflow.dataset.read import Solutions
from gaitflow.search.solution import Solution
from gaitflow.store.journal import Entry

JUDGED = ("cost_error", "resolved")  # columns that labels have since costs are compared with those of a finer mesh
EFFORT = ("tried", "screened", "solves", "solver_cpu_s")
PAUSE_S = 120.0  # a gap in the journal longer than any solve's silence: nobody was running


def run(scenario: Scenario, solutions: Solutions, labels: pd.DataFrame, journal: Sequence[Entry]) -> dict[str, Any]:
    """The document: a row a task, with its label, the label's violation and its worst gap between knots."""
    frame, axes = solutions.frame(), scenario.tasks.space.columns
    best = {(*row.task.on(axes), row.pattern): row for row in solutions if row.trajectory is not None}
    effort = _effort(frame, axes)
    rows, kinds = [], dict[str, float]()
    told = (*axes, "split", "status", "gait", "pattern", "cost", "margin", "runner_up", *JUDGED)
    for task in labels.to_dict("records"):
        place = tuple(task[axis] for axis in axes)
        chosen = best.get((*place, task["pattern"]))
        rows.append({key: task[key] for key in told if key in task})
        rows[-1] |= effort.get(place, {})
        if chosen is not None:
            found = _judge(solutions, chosen)
            kinds = {kind: max(kinds.get(kind, 0.0), value) for kind, value in found.items()}
            rows[-1] |= {
                "violation": max(found.values()),
                GAP: motion_checks(solutions.record["scenario"], chosen)[GAP],
            }
    solvable = frame[frame["status"] == "solved"].groupby(list(axes)).ngroups
    solved = labels["status"] == "solved"
    cpu = math.fsum(entry.cpu_s for entry in journal if entry.event == "stored" and entry.kept)
    summary = {
        "tasks": len(labels),
        "labelled": int(solved.sum()),
        "infeasible_tasks": int((~solved).sum()),
        "feasible_but_unlabelled": solvable - int(solved.sum()),
        "patterns_per_task": len(frame) // max(len(labels), 1),
        "rows_by_status": {str(k): int(v) for k, v in frame["status"].value_counts().items()},
        "solver_calls": int(frame["solves"].sum()),
        "iterations": int(frame["iterations"].sum()),
        **{f"{key}_per_task_median": _median(rows, key) for key in EFFORT},
        "worst_label_violation": max((row["violation"] for row in rows if "violation" in row), default=None),
        "worst_violation_by_kind": kinds,
        "worst_gap_between_knots": max((row["gap_between_knots"] for row in rows if "violation" in row), default=None),
        "wall_s": active_seconds(journal),
        "cpu_s": cpu,
        "cpu_s_per_labelled_task": cpu / int(solved.sum()) if solved.any() else None,
        **_resolution(labels[solved]),
        "gaits": {str(k): int(v) for k, v in labels.loc[solved, "gait"].value_counts().items()},
    }
    notes = (
        "violation: worst scaled constraint violation by the independent check (at most 1e-6 is feasible)",
        "gap_between_knots: largest difference of position [m] or angle [rad] in one step between the stored motion "
        "and the continuous one under the same forces",
        "worst_violation_by_kind, worst_gap_between_knots: over the labels' motions, each judged anew in numpy by code "
        "that the transcription does not share",
        "of a task, tried: patterns for which a program was solved; screened: those that a sound condition ruled out; "
        "solves: solver calls; solver_cpu_s: their CPU time. cpu_s, cpu_s_per_labelled_task: of the whole run, with "
        "building and storing",
        "cost_error_*, resolved: of the labels, whose winner and runner-up were solved on a finer mesh as well; a "
        "label is resolved when the margin exceeds what may be left of their errors, or they tie",
        "wall_s: from the run's journal, on the machine's share that the run got; other work may have run beside it",
    )
    return document("map", scenario.name, rows, summary, notes)


def _resolution(labels: pd.DataFrame) -> dict[str, Any]:
    """How far costs are off by a finer mesh, and how many labels that leaves open; nothing where none was compared."""
    if not set(JUDGED) <= set(labels.columns) or labels["cost_error"].isna().all():
        return {}
    errors = labels["cost_error"].dropna()
    return {
        "cost_error_median": float(errors.median()),
        "cost_error_max": float(errors.max()),
        "resolved": int(labels["resolved"].sum()),
    }


def _effort(frame: pd.DataFrame, axes: Sequence[str]) -> dict[tuple[float, ...], dict[str, Any]]:
    """What each task took, by its values on the axes; see the notes."""
    counted = frame.assign(
        screened=frame["status"] == "screened", tried=frame["solves"] > 0, solver_cpu_s=frame["cpu_s"]
    )
    sums = counted.groupby(list(axes), as_index=False)[list(EFFORT)].sum()
    return {tuple(row[axis] for axis in axes): {key: row[key] for key in EFFORT} for row in sums.to_dict("records")}


def _median(rows: Sequence[Mapping[str, Any]], key: str) -> float | None:
    known = [row[key] for row in rows if key in row]
    return statistics.median(known) if known else None


def active_seconds(journal: Sequence[Entry]) -> float:
    """Seconds from the first to the last entry without pauses; a unit in work is no pause."""
    total, until = 0.0, None
    spans = sorted((entry.time - entry.wall_s, entry.time) for entry in journal if entry.event == "stored")
    for start, end in spans:
        if until is None or start > until + PAUSE_S:
            total, until = total + (end - start), end
        elif end > until:
            total, until = total + (end - until), end
    return total


def _judge(solutions: Solutions, row: Solution) -> dict[str, float]:
    assert row.trajectory is not None
    scenario = solutions.record["scenario"]
    return violations(scenario, row.trajectory, row.task, row.pattern)
