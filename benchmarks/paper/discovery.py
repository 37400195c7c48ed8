"""Finding a task's best gait: trying all patterns against the paper's Bonmin restarts, cost against CPU time.

Both search the same tasks on the same machine, one after the other, each in a process with one thread. `patterns` is
taken at its worst: every task alone, without the neighbour from which a chain of tasks starts.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from benchmarks.child import Child
from benchmarks.document import document
from benchmarks.rows import Row, RowStore
from benchmarks.search import search as measuring
from benchmarks.search.search import BONMIN_LIMIT_S, bonmin, patterns, search
from benchmarks.search.tasks import spread_tasks, task_key, task_values
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset.labels import relative_cost

SAME_COST = 1e-4  # relative: restarts this close to their best agree with it
SEARCH_LIMIT_S = 3600.0
NOTES = (
    "cost_worse_rel = (patterns - bonmin) / bonmin, the best of each; null where one of them found no motion. "
    "cost_worse_max_rel is the largest over tasks, negative when patterns was cheaper everywhere, and null when "
    "patterns found no motion where Bonmin did (missed_by_patterns).",
    "cpu_ratio = CPU time of all Bonmin restarts of a task over that of patterns. Of Bonmin it counts the solver calls "
    "alone, of patterns everything: transcription, building solvers, screening and solving. cpu_ratio_solver counts "
    "the solver calls of both; cpu_ratio_per_restart is cpu_ratio for a single restart. cpu_ratio_in_map is against "
    "what the same task took patterns in the map's run, where it starts from its neighbour; null without that run.",
    "A restart fails when Bonmin throws, crashes, ends without a pattern or with one whose motion our check finds "
    "infeasible after a polish in bounds form. Failed restarts count with their time.",
    f"Bonmin may take {BONMIN_LIMIT_S:g} s a restart. A restart agrees when it is within {SAME_COST:g} of the best.",
)

Solve = Callable[[Row], dict[str, Any]]


def run(
    scenario: Scenario,
    tasks: int = 3,
    restarts: int = 15,
    seed: int = 0,
    runs: Path = Path("runs"),
    map_cpu_s: Mapping[Task, float] = MappingProxyType({}),
) -> Row:
    """The document: a row a task, with all of its restarts; rows measured before, kept below `runs`, are reused.

    `map_cpu_s` says what grid tasks took in a run of the whole map [s of solver calls]. Raises ValueError when
    the grid has fewer tasks, or for less than 1 task or restart.
    """
    chosen = spread_tasks(scenario, tasks, seed)
    if restarts < 1:
        raise ValueError(f"restarts = {restarts}: Bonmin needs at least 1")
    store = RowStore("discovery", scenario, runs, [measuring])
    with (
        Child("benchmarks.search.search:Search", {"scenario": patterns(scenario).as_data()}) as ours,
        Child("benchmarks.search.search:Search", {"scenario": bonmin(scenario).as_data()}) as theirs,
    ):
        solve = {
            "patterns": partial(_solve, scenario, ours, SEARCH_LIMIT_S),
            "bonmin": partial(_solve, scenario, theirs, 3 * BONMIN_LIMIT_S),  # wall time: the machine may be busy
        }
        keys = search_keys(scenario, chosen, restarts, seed)
        measured = store.rows(keys, lambda key: solve[key["method"]](key))
    places = [task_key(scenario, task) for task in chosen]
    rows: list[Row] = [place | compare(*found) for place, found in zip(places, by_task(measured, places), strict=True)]
    for task, row in zip(chosen, rows, strict=True):
        in_map = map_cpu_s.get(task)
        row["patterns"]["cpu_s_in_map"] = in_map
        row["cpu_ratio_in_map"] = row["bonmin"]["cpu_s"] / in_map if in_map else None
    return document("discovery", scenario.name, rows, summarise(rows, restarts), NOTES)


def search_keys(scenario: Scenario, tasks: Sequence[Task], restarts: int, seed: int) -> list[Row]:
    """Keys of all rows: each task by patterns, then by Bonmin from each seed."""
    keys: list[Row] = []
    for task in tasks:
        where = task_key(scenario, task)
        keys.append({**where, "method": "patterns", "seed": None})
        keys += [{**where, "method": "bonmin", "seed": seed + number} for number in range(restarts)]
    return keys


def by_task(measured: Sequence[Row], tasks: Sequence[Mapping[str, float]]) -> list[tuple[Row, list[Row]]]:
    """For each task, given by `task_key`, the row of patterns and those of Bonmin's restarts."""
    pairs = []
    for task in tasks:
        here = [row for row in measured if task.items() <= row.items()]
        ours = next(row for row in here if row["method"] == "patterns")
        pairs.append((ours, [row for row in here if row["method"] == "bonmin"]))
    return pairs


def compare(ours: Row, restarts: Sequence[Row]) -> Row:
    """One task: the best of both, what it cost to find, and how Bonmin's restarts went."""
    solved = [row for row in restarts if row["cost"] is not None]
    best = min(solved, key=lambda row: row["cost"]) if solved else None
    both = best is not None and ours["cost"] is not None
    cpu = sum(row["cpu_s"] for row in restarts)
    shown = ("gait", "pattern", "cost", "violation", "status")
    return {
        "patterns": {key: ours[key] for key in (*shown, "solves", "counts", "cpu_s", "whole_cpu_s", "measured")},
        "bonmin": {
            **{key: best[key] if best else None for key in shown},
            "cpu_s": cpu,
            "cpu_s_per_restart": cpu / len(restarts),
            "failed": len(restarts) - len(solved),
            "agree": sum(row["cost"] <= best["cost"] * (1 + SAME_COST) for row in solved) if best else 0,
            "gaits_found": len({row["gait"] for row in solved}),
        },
        "cost_worse_rel": float(relative_cost(np.asarray(ours["cost"]), best["cost"])) if best and both else None,
        "cpu_ratio": cpu / ours["whole_cpu_s"],
        "cpu_ratio_solver": cpu / ours["cpu_s"] if ours["cpu_s"] else None,
        "restarts": [
            {key: row[key] for key in ("seed", *shown, "solver_status", "cpu_s", "measured")} for row in restarts
        ],
    }


def summarise(rows: Sequence[Row], restarts: int) -> Row:
    """The summary over tasks; see NOTES for what its numbers mean."""
    worse = [row["cost_worse_rel"] for row in rows if row["cost_worse_rel"] is not None]
    ratios = [row["cpu_ratio"] for row in rows]
    solver = [row["cpu_ratio_solver"] for row in rows if row["cpu_ratio_solver"] is not None]
    in_map = [row["cpu_ratio_in_map"] for row in rows if row.get("cpu_ratio_in_map") is not None]
    missed = [_only(row, "bonmin", "patterns") for row in rows]
    return {
        "tasks": len(rows),
        "restarts": restarts,
        "cost_worse_max_rel": None if any(missed) or not worse else max(worse),
        "cost_worse_min_rel": min(worse, default=None),
        "cpu_ratio_median": statistics.median(ratios),
        "cpu_ratio_min": min(ratios),
        "cpu_ratio_max": max(ratios),
        "cpu_ratio_solver_median": statistics.median(solver) if solver else None,
        "cpu_ratio_per_restart_median": statistics.median(ratios) / restarts,
        "cpu_ratio_in_map_median": statistics.median(in_map) if in_map else None,
        "patterns_cpu_s_median": statistics.median(row["patterns"]["whole_cpu_s"] for row in rows),
        "bonmin_cpu_s_per_restart_median": statistics.median(row["bonmin"]["cpu_s_per_restart"] for row in rows),
        "bonmin_restarts_failed": sum(row["bonmin"]["failed"] for row in rows),
        "bonmin_restarts_agree": sum(row["bonmin"]["agree"] for row in rows),
        "missed_by_patterns": sum(missed),
        "missed_by_bonmin": sum(_only(row, "patterns", "bonmin") for row in rows),
    }


def _only(row: Row, one: str, other: str) -> bool:
    return row[one]["cost"] is not None and row[other]["cost"] is None


def _solve(scenario: Scenario, child: Child, limit_s: float, key: Row) -> dict[str, Any]:
    return search(child, task_values(scenario, key), key["seed"], limit_s)
