"""The tables of the report, as text: gaits, ties, unsolved tasks, checks, effort, classifiers, provenance."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, get_args

import pandas as pd

from gaitflow.core.check import FEASIBLE, between_knots, violations
from gaitflow.core.gaits import Pattern, diagram
from gaitflow.core.task_space import TaskSpace
from gaitflow.report import axis_text
from gaitflow.report.map_tasks import SPLIT_WORDS, map_task_words, of_map
from gaitflow.report.palette import ordered_gaits
from gaitflow.report.winners import trajectory_of
from gaitflow.search.solution import Solution, Status

QUALITIES = (
    ("accuracy", "accuracy"),
    ("macro_f1", "macro F1"),
    ("top1_beyond_ties", "right but for ties"),
    ("regret_mean", "mean regret"),
    ("infeasible_rate", "infeasible picks"),
)


JUDGED_COLUMNS = ("worst cost error", "labels not resolved")


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
    """A row a gait: its diagram, tasks won, range of costs, mean margin to the runner-up, and how sure the labels are.

    The mean is over tasks that have a runner-up, held-out tasks included. The worst error of a cost, and how many
    labels it leaves open, are told where the labels have them.
    """
    solved = labels[labels["status"] == "solved"]
    judged = refined(labels)
    rows = []
    for name in ordered_gaits(solved["gait"]):
        won = solved[solved["gait"] == name]
        margins = won["margin"][won["margin"].map(math.isfinite)]
        row = [
            name,
            diagram(Pattern.from_text(won["gait_key"].iloc[0]), leg_names),
            str(int(of_map(won).sum())),
            str(int((~of_map(won)).sum())),
            _range(won["cost"].min(), won["cost"].max()),
            percent(float(margins.mean())),
            str(int((won["ties"].map(len) > 1).sum())),
        ]
        if judged:
            row += [percent(float(won["cost_error"].max())), str(int((~won["resolved"].astype(bool)).sum()))]
        rows.append(tuple(row))
    columns = ("gait", "pattern", f"{map_task_words(labels)}s", "held-out tasks", "cost", "mean margin", "ties")
    return Table((*columns, *(JUDGED_COLUMNS if judged else ())), tuple(rows))


def _range(low: float, high: float) -> str:
    return number(low) if number(low) == number(high) else f"{number(low)} to {number(high)}"


def tie_table(labels: pd.DataFrame, space: TaskSpace) -> Table:
    """A row a task at which gaits tie, cheapest gait first, with the label that is learnt."""
    tied = _sorted(labels[labels["ties"].map(len) > 1], space)
    rows = [
        (*_task(row, space), ", ".join(row["ties"]), percent(row["margin"]), row["label"])
        for row in tied.to_dict("records")
    ]
    return Table((*_headings(space), "split", "gaits that tie", "margin", "learnt as"), tuple(rows))


def unsolved_table(labels: pd.DataFrame, space: TaskSpace) -> Table:
    """A row a task at which no gait was found, with its status: infeasible, or failed (see `mark_failed`)."""
    missing = _sorted(labels[labels["status"] != "solved"], space)
    rows = [(*_task(row, space), str(row["status"])) for row in missing.to_dict("records")]
    return Table((*_headings(space), "split", "status"), tuple(rows))


def unresolved_table(labels: pd.DataFrame, space: TaskSpace) -> Table:
    """A row a task whose label the mesh does not decide, with the margin and the error of the costs behind it.

    Without a row where nothing was compared with a finer mesh.
    """
    open_ = labels[~labels["resolved"].astype(bool)] if refined(labels) else labels.iloc[:0]
    rows = [
        (*_task(row, space), row["gait"], row["runner_up"], percent(row["margin"]), percent(row["cost_error"]))
        for row in _sorted(open_[open_["status"] == "solved"], space).to_dict("records")
    ]
    return Table((*_headings(space), "split", "gait", "runner-up", "margin", "cost error"), tuple(rows))


def refined(labels: pd.DataFrame) -> bool:
    """Whether costs behind the labels were compared with those on a finer mesh."""
    return {"cost_error", "resolved"} <= set(labels.columns) and bool(labels["cost_error"].notna().any())


def _headings(space: TaskSpace) -> tuple[str, ...]:
    return tuple(map(axis_text.heading, space.columns))


def _sorted(labels: pd.DataFrame, space: TaskSpace) -> pd.DataFrame:
    return labels.sort_values(["split", *space.columns])


def _task(row: Mapping[Any, Any], space: TaskSpace) -> tuple[str, ...]:
    return *(f"{row[axis]:.4g}" for axis in space.columns), SPLIT_WORDS[row["split"]]


def check_table(scenario: Mapping[str, Any], motions: Iterable[Solution]) -> Table:
    """Every motion checked again by `gaitflow.core.check`: a row a kind of constraint, its worst value and its place.

    `scenario` is `Scenario.as_data()`; values are scaled. The row of the worst kind is marked.
    """
    worst = _worst(motions, lambda motion: violations(scenario, trajectory_of(motion), motion.task, motion.pattern))
    axes = TaskSpace.of(scenario).columns
    rows = [
        (kind, f"{value:.1e}", "yes" if value <= FEASIBLE else "NO", *_place(at if value > 0 else None, axes))
        for kind, (value, at) in worst.items()
    ]
    values = [value for value, _ in worst.values()]
    marked = values.index(max(values)) if values else None
    headings = map(axis_text.heading, axes)
    return Table(("constraint", "worst value", f"within {FEASIBLE:g}", *headings), tuple(rows), marked)


def between_knots_table(scenario: Mapping[str, Any], motions: Iterable[Solution]) -> Table:
    """Every motion checked between its knots, on a grid ten times finer: a row a kind, its worst value and its place.

    In m and rad (dynamics), m (box, penetration) and shares of the weight (friction).
    """
    worst = _worst(motions, lambda motion: between_knots(scenario, trajectory_of(motion), motion.task, motion.pattern))
    axes = TaskSpace.of(scenario).columns
    rows = [(kind, f"{value:.1e}", *_place(at if value > 0 else None, axes)) for kind, (value, at) in worst.items()]
    return Table(("constraint", "worst value", *map(axis_text.heading, axes)), tuple(rows))


def _worst(
    motions: Iterable[Solution], judge: Callable[[Solution], Mapping[str, float]]
) -> dict[str, tuple[float, Solution]]:
    """By kind of constraint the worst value, and the motion that has it."""
    worst: dict[str, tuple[float, Solution]] = {}
    for motion in motions:
        for kind, value in judge(motion).items():
            if kind not in worst or value > worst[kind][0]:
                worst[kind] = value, motion
    return worst


def _place(motion: Solution | None, axes: Sequence[str]) -> tuple[str, ...]:
    return tuple("–" if motion is None else f"{motion.task[axis]:.4g}" for axis in axes)


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
    """What made the dataset: `record` is the provenance record of its file (gaitflow.tables.provenance)."""
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
