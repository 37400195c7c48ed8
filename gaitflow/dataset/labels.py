"""From solves to labels: which gait costs least at each task, by how much, how surely, and which gaits tie.

Costs carry the error of their mesh. Where the search also solved a gait on a finer mesh, that cost decides; a label
says how large the error was, and whether the margin exceeds it. Neighbouring gaits often cost the same to 0.1 %, and
which of them comes out first there is solver noise: see `gaitflow.dataset.neighbours` for what is learnt then.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from gaitflow.core.gaits import Pattern
from gaitflow.core.mesh_error import error_left
from gaitflow.core.names import gait_kind, gait_name
from gaitflow.core.task import Task
from gaitflow.dataset.neighbours import neighbourhood_labels
from gaitflow.search.screen import IMPOSSIBLE
from gaitflow.tables.schema import task_columns

MAX_VIOLATION = 1e-6  # worst scaled constraint violation of a solve that counts
COSTS = ["gait", "gait_key", "pattern", "cost", "refined_cost", "refined_knots", "excess"]
LABELS = [
    "status", "gait", "gait_key", "pattern", "cost", "refined_cost", "margin", "runner_up", "ties", "cost_error",
    "resolved", "label",
]  # fmt: skip
_NO_NUMBERS = dict.fromkeys(["cost", "refined_cost", "margin", "cost_error"], np.nan)
_NO_NAMES = dict.fromkeys(["gait", "gait_key", "pattern", "runner_up", "label"], "")


def gait_costs(solutions: pd.DataFrame, leg_names: Sequence[str]) -> pd.DataFrame:
    """The least cost of every gait at every task, over the patterns that realise it (AABC and ABBC are one gait).

    `solutions` has the scalar columns of a table of solutions, a row a solve. A solve counts when its status is
    "solved", its violation at most MAX_VIOLATION and its cost finite. Returns the task's columns and COSTS, sorted by
    task and by `excess`: a gait that is absent at a task has no known feasible motion there.

    `cost` is on the scenario's mesh, `refined_cost` that of the same pattern on a finer one (NaN when unknown), of
    `refined_knots` a phase. `excess` is the share by which a gait is dearer than the best of its task, 0 for that one.
    It compares refined costs; a gait without one is taken to gain by a finer mesh what those with one gain at least.
    So it never comes before one that is cheaper on the scenario's mesh and was refined.
    """
    task = task_columns(solutions.columns)
    good = (solutions["status"] == "solved") & (solutions["violation"] <= MAX_VIOLATION)
    rows = solutions[good & np.isfinite(solutions["cost"])].rename(columns={"gait": "gait_key"})
    rows = rows.assign(gait=rows["gait_key"].map(_names(rows["gait_key"].unique(), leg_names)).astype(str))
    rows = rows.sort_values([*task, "cost", "pattern"], kind="stable")
    rows = rows.assign(compared=_comparable(rows, task))
    # What is known of a gait on the finer mesh goes before what is assumed.
    rows = rows.assign(assumed=rows["refined_cost"].isna())
    rows = rows.sort_values([*task, "assumed", "compared", "cost", "pattern"], kind="stable")
    rows = rows.drop_duplicates([*task, "gait_key"])
    rows = rows.sort_values([*task, "compared", "assumed", "cost", "pattern"], kind="stable")
    best = rows.groupby(task, sort=False)["compared"].transform("first")
    rows = rows.assign(excess=relative_cost(rows["compared"].to_numpy(), best.to_numpy()))
    return rows[[*task, *COSTS]].reset_index(drop=True)


def label_tasks(costs: pd.DataFrame, tasks: Iterable[Task], tie_tolerance: float, knots_per_phase: int) -> pd.DataFrame:
    """One row a task, in the order given: the task's columns and LABELS. `costs` is what `gait_costs` returns.

    `gait` is the cheapest one and `cost` its cost, `margin` the share by which the runner-up is dearer (inf without
    one), `ties` the gaits within `tie_tolerance` of the cheapest, that one first. `cost_error` is how far the costs of
    these two, with `knots_per_phase`, are from those on a finer mesh, as a share, the larger of the two; NaN when
    either is unknown. `resolved` says whether it is sure which of them is cheaper, or that they tie: the margin exceeds
    what may be left of either error on the finer mesh, or lies within the tolerance and the best was solved there. An
    only gait is the cheapest for sure. `label`, what is learnt, is one of `ties`: see `gaitflow.dataset.neighbours`. A
    task with no known feasible gait has the status "infeasible", empty names and NaN for its numbers.
    """
    task_names = task_columns(costs.columns)
    *axes, _ = task_names
    known = {key: group for key, group in costs.groupby(task_names, sort=False)}
    rows = [
        dict(zip(axes, task.on(axes), strict=True))
        | {"split": task.split}
        | _label(known.get((*task.on(axes), task.split)), tie_tolerance, knots_per_phase)
        for task in tasks
    ]
    labels = pd.DataFrame(rows, columns=[*task_names, *LABELS])
    labels["label"] = neighbourhood_labels(labels)
    return labels


def mark_failed(labels: pd.DataFrame, solutions: pd.DataFrame) -> pd.DataFrame:
    """The labels with the status "failed" instead of "infeasible" where a feasible gait may have been missed.

    A task is infeasible when every one of its patterns that was tried ended infeasible or was screened as impossible.
    A solver that crashed, threw or ran into its limits says nothing about feasibility, and neither does a probe on a
    coarse mesh, a screen by cost, or no row at all. `solutions` as in `gait_costs`.
    """
    task = task_columns(labels.columns)
    impossible = (solutions["status"] == "screened") & solutions["solver_status"].isin(IMPOSSIBLE)
    verdict = (solutions["status"] == "infeasible") | impossible
    ruled_out = verdict.groupby([solutions[column] for column in task]).all()
    infeasible = set(ruled_out.index[ruled_out])
    keys = zip(*(labels[column] for column in task), strict=True)
    status = [
        "failed" if old == "infeasible" and key not in infeasible else old
        for key, old in zip(keys, labels["status"], strict=True)
    ]
    return labels.assign(status=status)


def relative_cost(cost: np.ndarray, best: np.ndarray | float) -> np.ndarray:
    """(cost - best) / |best|, elementwise: the share by which a choice is dearer; inf where cost is."""
    return np.asarray((cost - best) / np.maximum(np.abs(best), np.finfo(float).tiny))


def _label(group: pd.DataFrame | None, tolerance: float, knots: int) -> dict[str, object]:
    """The columns LABELS of a task whose gaits have these costs, the cheapest first."""
    if group is None:
        return _NO_NAMES | _NO_NUMBERS | {"status": "infeasible", "ties": [], "resolved": False}
    gaits, excess = group["gait"].tolist(), group["excess"].to_numpy()
    best, first_two = group.iloc[0], group.iloc[:2]
    margin = float(excess[1]) if len(excess) > 1 else np.inf
    errors = relative_cost(first_two["cost"].to_numpy(), first_two["refined_cost"].to_numpy())
    return {
        "status": "solved",
        **{name: best[name] for name in ("gait", "gait_key", "pattern", "cost", "refined_cost")},
        "margin": margin,
        "runner_up": gaits[1] if len(gaits) > 1 else "",
        "ties": [gait for gait, more in zip(gaits, excess, strict=True) if more <= tolerance],
        "cost_error": float(np.abs(errors).max()),  # NaN when either is
        "resolved": margin == np.inf or _is_resolved(first_two, margin, tolerance, knots),
        "label": best["gait"],
    }


def _is_resolved(first_two: pd.DataFrame, margin: float, tolerance: float, knots: int) -> bool:
    finer_mesh = first_two["refined_knots"] > knots
    if margin <= tolerance:
        return bool(finer_mesh.iloc[0])
    if not finer_mesh.all():
        return False
    refined = first_two[["cost", "refined_cost", "refined_knots"]].itertuples(index=False)
    left = max(error_left(cost, knots, finer, int(mesh)) for cost, finer, mesh in refined)
    return bool(margin > left)


def _comparable(rows: pd.DataFrame, task: list[str]) -> pd.Series:
    """Costs on one scale a task: on the finer mesh, or what they would be there by the largest ratio that is known."""
    ratio = (rows["refined_cost"] / rows["cost"]).where(rows["cost"] != 0.0, 1.0)
    largest = ratio.groupby([rows[column] for column in task]).transform("max").fillna(1.0)  # skips what is not known
    return rows["refined_cost"].where(rows["refined_cost"].notna(), rows["cost"] * largest)


def _names(keys: Sequence[str], leg_names: Sequence[str]) -> dict[str, str]:
    """The name of each gait; where a task tells mirror images apart, which share a name, their contacts are in it."""
    patterns = {key: Pattern.from_text(key) for key in keys}
    names = {key: gait_name(pattern, leg_names) for key, pattern in patterns.items()}
    given = list(names.values())
    return {
        key: name if given.count(name) == 1 else f"{gait_kind(patterns[key], leg_names)} {key}"
        for key, name in names.items()
    }
