"""Table I of the paper: time, successful runs and consistency of the MINLP and of optimising a picked gait; and ours.

A task in the plane is small enough to run the MINLP on each, and to compare all with every pattern's optimum.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks import child
from benchmarks.document import document
from benchmarks.paper import fixed_gait, table
from benchmarks.paper.table import MINLP, judge, summarise
from benchmarks.rows import Row, RowStore
from benchmarks.search import search as searching
from benchmarks.search.search import BONMIN_LIMIT_S, bonmin, patterns, search
from benchmarks.search.tasks import task_key, task_values
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task

METHODS = (MINLP, *fixed_gait.METHODS, "patterns")
NOTES = (
    "minlp: one Bonmin run from a random start, polished in bounds form; it may take "
    f"{BONMIN_LIMIT_S:g} s. patterns: every pattern of the task searched, cold; what the others are compared with.",
    *table.NOTES,
)


def run(
    scenario: Scenario, artifact: Path, tasks: int = 10, restarts: int = 1, seed: int = 0, runs: Path = Path("runs")
) -> Row:
    """The document: a row a task, method and restart; rows measured before, kept below `runs`, are reused.

    `restarts` are Bonmin runs a task. Raises ValueError for less than 1, and as `table.draw_tasks` does.
    """
    if restarts < 1:
        raise ValueError(f"restarts = {restarts}: must be at least 1")
    chosen, warm_up = table.draw_tasks(scenario, artifact, tasks, seed)
    measured = table.references("table1", scenario, patterns(scenario), chosen, runs)
    measured += _bonmin_runs(scenario, chosen, range(seed, seed + restarts), runs)
    measured += table.fixed_gaits("table1", scenario, artifact, chosen, warm_up, seed, runs)
    rows = judge(measured, scenario)
    return document("table1", scenario.name, rows, summarise(rows), NOTES)


def _bonmin_runs(scenario: Scenario, tasks: Sequence[Task], seeds: Sequence[int], runs: Path) -> list[Row]:
    keys = [task_key(scenario, task) | {"method": MINLP, "seed": seed} for task in tasks for seed in seeds]
    with child.Child("benchmarks.search.search:Search", {"scenario": bonmin(scenario).as_data()}) as process:
        return RowStore("table1", scenario, runs, [searching]).rows(
            keys, lambda key: search(process, task_values(scenario, key), key["seed"], 3 * BONMIN_LIMIT_S)
        )
