"""The tables of the report, as text: gaits, ties, unsolved tasks, checks, effort, classifiers, provenance."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, get_args

import pandas as pd

from gaitflow.core.check import FEASIBLE, violations
from gaitflow.core.gaits import Pattern, diagram
from gaitflow.report.palette import ordered_gaits
from gaitflow.report.winners import trajectory_of
from gaitflow.search.solution import Solution, Status

GAP = "gap_between_knots"  # optional column of the labels: how far a step is from the continuous motion
QUALITIES = (
    ("accuracy", "accuracy"),
    ("macro_f1", "macro F1"),
    ("top1_beyond_ties", "right but for ties"),
    ("regret_mean", "mean regret"),
    ("infeasible_rate", "infeasible picks"),
)


@dataclass(frozen=True)
class Table:
    """Text in rows; `marked` is the index of a row to stand out."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...] = field(default=())
    marked: int | None = None


def number(value: float | None) -> str:
    """A number with 3 significant digits; "–" where there is none, "∞" for infinity."""
    if value is None or math.isnan(value):
        return "–"
    return "∞" if math.isinf(value) else f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def percent(value: float | None) -> str:
    """A fraction in per cent with 3 significant digits; below 0.001 % only that it is."""
    if value is not None and 0 < value < 1e-5:
        return "< 0.001 %"
    return number(value) if value is None or not math.isfinite(value) else f"{number(100 * value)} %"


def gait_table(labels: pd.DataFrame, leg_names: Sequence[str]) -> Table:
    """A row a gait: its diagram, tasks won, range of costs, mean margin to the runner-up; gaps when given.

    The mean is over tasks that have a runner-up, held-out tasks included.
    """
    solved = labels[labels["status"] == "solved"]
    with_gap = GAP in labels.columns
    columns = ["gait", "pattern", "grid tasks", "held-out tasks", "cost", "mean margin", "ties"]
    rows = []
    for name in ordered_gaits(solved["gait"]):
        won = solved[solved["gait"] == name]
        margins = won["margin"][won["margin"].map(math.isfinite)]
        row = [
            name,
            diagram(Pattern.from_text(won["gait_key"].iloc[0]), leg_names),
            str(int((won["split"] == "grid").sum())),
            str(int((won["split"] != "grid").sum())),
            _range(won["cost"].min(), won["cost"].max()),
            percent(float(margins.mean())),
            str(int((won["ties"].map(len) > 1).sum())),
        ]
        rows.append((*row, number(float(won[GAP].max()))) if with_gap else tuple(row))
    return Table((*columns, "worst gap between knots [m or rad]") if with_gap else tuple(columns), tuple(rows))


def _range(low: float, high: float) -> str:
    return number(low) if number(low) == number(high) else f"{number(low)} to {number(high)}"


def tie_table(labels: pd.DataFrame) -> Table:
    """A row a task at which gaits tie, cheapest gait first, with the label that is learnt."""
    tied = labels[labels["ties"].map(len) > 1].sort_values(["split", "speed", "cycle_duration"])
    rows = [
        (*_task(row), ", ".join(row["ties"]), percent(row["margin"]), row["label"]) for row in tied.to_dict("records")
    ]
    return Table(("v [m/s]", "T [s]", "split", "gaits that tie", "margin", "learnt as"), tuple(rows))


def unsolved_table(labels: pd.DataFrame) -> Table:
    """A row a task at which no gait was found, with its status: infeasible, or failed (see `mark_failed`)."""
    missing = labels[labels["status"] != "solved"].sort_values(["split", "speed", "cycle_duration"])
    rows = [(*_task(row), str(row["status"])) for row in missing.to_dict("records")]
    return Table(("v [m/s]", "T [s]", "split", "status"), tuple(rows))


def _task(row: Mapping[Any, Any]) -> tuple[str, str, str]:
    return f"{row['speed']:.4g}", f"{row['cycle_duration']:.4g}", str(row["split"]).replace("_", "-")


def check_table(scenario: Mapping[str, Any], motions: Iterable[Solution]) -> Table:
    """Every motion checked again by `gaitflow.core.check`: a row a kind of constraint, its worst value and its place.

    `scenario` is `Scenario.as_data()`; values are scaled. The row of the worst kind is marked.
    """
    worst: dict[str, tuple[float, Solution]] = {}
    for motion in motions:
        found = violations(scenario, trajectory_of(motion), motion.speed, motion.cycle_duration, motion.pattern)
        for kind, value in found.items():
            if kind not in worst or value > worst[kind][0]:
                worst[kind] = value, motion
    rows = [
        (kind, f"{value:.1e}", "yes" if value <= FEASIBLE else "NO")
        + ((f"{at.speed:.4g}", f"{at.cycle_duration:.4g}") if value > 0 else ("–", "–"))
        for kind, (value, at) in worst.items()
    ]
    values = [value for value, _ in worst.values()]
    marked = values.index(max(values)) if values else None
    return Table(("constraint", "worst value", f"within {FEASIBLE:g}", "v [m/s]", "T [s]"), tuple(rows), marked)


def effort_table(solutions: Iterable[Solution]) -> Table:
    """How the solves ended, what they took, and the worst violation among those that count as solved."""
    counts: Counter[str] = Counter()
    solves, cpu, worst = 0, 0.0, -math.inf
    for solution in solutions:
        counts[solution.status] += 1
        solves += solution.solves
        cpu += solution.cpu_s
        if solution.status == "solved":
            worst = max(worst, solution.violation)
    rows = [(status, f"{counts[status]:,}") for status in get_args(Status)]
    rows += [("solver calls", f"{solves:,}"), ("solver CPU time", f"{number(cpu / 60)} min")]
    rows += [("worst scaled violation of a solved task", number(worst if counts["solved"] else None))]
    return Table(("patterns at tasks", "count"), tuple(rows))


def learning_table(learning: Mapping[str, Any]) -> Table:
    """A row a method, the published one marked; `learning` is `Training.as_data()`.

    A cell has two numbers: on the cross-validation folds / on the held-out tasks. Regret is the cost of the pick over
    the least cost, minus one.
    """
    rows = []
    for one in learning["competitors"]:
        judged = [(one["cross_validation"][key], one["held_out"][key]) for key, _ in QUALITIES]
        rows.append((one["method"], *(f"{percent(folds)} / {percent(held_out)}" for folds, held_out in judged)))
    methods = [row[0] for row in rows]
    return Table(("method", *(title for _, title in QUALITIES)), tuple(rows), methods.index(learning["method"]))


def provenance_table(record: Mapping[str, Any]) -> Table:
    """What made the dataset: `record` is the provenance record of its file (gaitflow.dataset.provenance)."""
    rows = [
        ("scenario digest", record["scenario_digest"]),
        ("units of work", f"{record['units']}, digest {record['units_digest']}"),
    ]
    for maker in record["made_by"]:
        code = maker["code"]
        state = ", with uncommitted changes" if code.get("dirty") else ""
        rows += [
            ("code", f"gaitflow {code['version']}, commit {code.get('commit') or 'unknown'}{state}"),
            ("packages", ", ".join(f"{name} {version}" for name, version in maker["packages"].items())),
            ("machine", f"{maker['cpu']}, {maker['system']}, Python {maker['python']}"),
        ]
    return Table(("what", "value"), (*rows, ("collected", record["created"])))
