"""From solves to labels: which gait costs least at each task, by how much, and which gaits tie.

Neighbouring gaits often cost the same to 0.1 %, and which of them comes out first there is solver noise. A label that
a classifier learns therefore follows, among the gaits that tie, what the neighbouring tasks say.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd

from gaitflow.config.tasks import Task
from gaitflow.core.gaits import Pattern
from gaitflow.core.names import gait_name
from gaitflow.search.screen import NO_ROOM, NO_SUPPORT, NO_SWING

MAX_VIOLATION = 1e-6  # worst scaled constraint violation of a solve that counts
TASK = ["speed", "cycle_duration", "split"]
IMPOSSIBLE = (NO_SUPPORT, NO_SWING, NO_ROOM)  # why a pattern is screened that no motion can have
COSTS = [*TASK, "gait", "gait_key", "pattern", "cost"]
LABELS = [*TASK, "status", "gait", "gait_key", "pattern", "cost", "margin", "runner_up", "ties", "label"]

Cell = tuple[int, int]  # place of a task on the grid: index of its speed, index of its cycle duration


def gait_costs(solutions: pd.DataFrame, leg_names: Sequence[str]) -> pd.DataFrame:
    """The least cost of every gait at every task, over the patterns that realise it (AABC and ABBC are one gait).

    `solutions` has the scalar columns of `Solution`, a row a solve. A solve counts when its status is "solved", its
    violation at most MAX_VIOLATION and its cost finite. Returns the columns COSTS, sorted by task and cost: a gait
    that is absent at a task has no known feasible motion there. Equal costs are ordered by pattern.
    """
    good = (solutions["status"] == "solved") & (solutions["violation"] <= MAX_VIOLATION)
    rows = solutions[good & np.isfinite(solutions["cost"])].rename(columns={"gait": "gait_key"})
    names = {key: gait_name(Pattern.from_text(key), leg_names) for key in rows["gait_key"].unique()}
    rows = rows.assign(gait=rows["gait_key"].map(names).astype(str))
    rows = rows.sort_values([*TASK, "cost", "pattern"], kind="stable").drop_duplicates([*TASK, "gait_key"])
    return rows[COSTS].reset_index(drop=True)


def label_tasks(costs: pd.DataFrame, tasks: Iterable[Task], tie_tolerance: float) -> pd.DataFrame:
    """One row a task, in the order given, with the columns LABELS.

    `gait` is the cheapest one, `margin` the relative cost of the runner-up gait over it (inf without one), `ties` the
    gaits within `tie_tolerance` of the cheapest, that one first. `label`, what is learnt, is one of `ties`: on the
    grid the one most common among the (up to 8) neighbours, iterated until nothing changes; for a held-out task the
    one most common at the corners of the grid cell it lies in. Held-out tasks influence no other label. A task with
    no known feasible gait has the status "infeasible", empty names and NaN for its numbers.
    """
    known = {key: group for key, group in costs.groupby(TASK, sort=False)}
    rows = [_row(task, known.get((task.speed, task.cycle_duration, task.split)), tie_tolerance) for task in tasks]
    labels = pd.DataFrame(rows, columns=LABELS)
    labels["label"] = _neighbourhood_labels(labels)
    return labels


def mark_failed(labels: pd.DataFrame, solutions: pd.DataFrame) -> pd.DataFrame:
    """The labels with the status "failed" instead of "infeasible" where a feasible gait may have been missed.

    A task is infeasible when every one of its patterns that was tried ended infeasible or was screened as impossible.
    A solver that crashed, threw or ran into its limits says nothing about feasibility, and neither does a probe on a
    coarse mesh, a screen by cost, or no row at all. `solutions` as in `gait_costs`.
    """
    impossible = (solutions["status"] == "screened") & solutions["solver_status"].isin(IMPOSSIBLE)
    verdict = (solutions["status"] == "infeasible") | impossible
    ruled_out = verdict.groupby([solutions[column] for column in TASK]).all()
    infeasible = set(ruled_out.index[ruled_out])
    keys = zip(*(labels[column] for column in TASK), strict=True)
    status = [
        "failed" if old == "infeasible" and key not in infeasible else old
        for key, old in zip(keys, labels["status"], strict=True)
    ]
    return labels.assign(status=status)


def _row(task: Task, group: pd.DataFrame | None, tolerance: float) -> dict[str, object]:
    row: dict[str, object] = {"speed": task.speed, "cycle_duration": task.cycle_duration, "split": task.split}
    if group is None:
        nothing = dict.fromkeys(["gait", "gait_key", "pattern", "runner_up", "label"], "")
        return row | nothing | {"status": "infeasible", "cost": np.nan, "margin": np.nan, "ties": []}
    cost = group["cost"].to_numpy()
    gaits = group["gait"].tolist()
    excess = relative_cost(cost, cost[0])
    best = group.iloc[0]
    return row | {
        "status": "solved",
        "gait": best["gait"],
        "gait_key": best["gait_key"],
        "pattern": best["pattern"],
        "cost": float(cost[0]),
        "margin": float(excess[1]) if len(cost) > 1 else np.inf,
        "runner_up": gaits[1] if len(cost) > 1 else "",
        "ties": [gait for gait, more in zip(gaits, excess, strict=True) if more <= tolerance],
        "label": best["gait"],
    }


def relative_cost(cost: np.ndarray, best: np.ndarray | float) -> np.ndarray:
    """(cost - best) / |best|, elementwise: the share by which a choice is dearer; inf where cost is."""
    return np.asarray((cost - best) / np.maximum(np.abs(best), np.finfo(float).tiny))


def _neighbourhood_labels(labels: pd.DataFrame) -> list[str]:
    speeds, durations = (np.unique(labels.loc[labels["split"] == "grid", axis]) for axis in ("speed", "cycle_duration"))
    rows = list(zip(labels["speed"], labels["cycle_duration"], labels["split"], strict=True))
    cells: dict[Cell, int] = {
        (int(np.searchsorted(speeds, v)), int(np.searchsorted(durations, t))): index
        for index, (v, t, split) in enumerate(rows)
        if split == "grid"
    }
    result = labels["label"].tolist()
    ties = labels["ties"].tolist()
    on_grid = {cell: result[index] for cell, index in cells.items()}
    # One task at a time, in a fixed order, and only for a strict majority: each change makes more neighbours agree,
    # so the sweeps end, and they end the same way every time.
    changed = True
    while changed:
        changed = False
        for cell in sorted(cells):
            index = cells[cell]
            choice = _most_common(on_grid, _around(cell), ties[index], on_grid[cell])
            changed |= choice != on_grid[cell]
            on_grid[cell] = choice
    for cell, index in cells.items():
        result[index] = on_grid[cell]
    for index, (v, t, split) in enumerate(rows):
        if split != "grid":
            i, j = np.searchsorted(speeds, v), np.searchsorted(durations, t)
            corners = [(int(i) - di, int(j) - dj) for di in (0, 1) for dj in (0, 1)]
            result[index] = _most_common(on_grid, corners, ties[index], result[index])
    return result


def _around(cell: Cell) -> list[Cell]:
    i, j = cell
    return [(i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1) if (di, dj) != (0, 0)]


def _most_common(on_grid: Mapping[Cell, str], cells: Iterable[Cell], allowed: Sequence[str], current: str) -> str:
    votes = Counter(on_grid[cell] for cell in cells if cell in on_grid and on_grid[cell] in allowed)
    # `allowed` is sorted by cost: among equally common gaits the cheapest, unless the present label is one of them.
    return max([current, *allowed], key=lambda gait: votes[gait]) if votes else current
