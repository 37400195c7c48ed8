"""Table II of the paper, the quadruped's: a picked gait optimised in three ways and ours, beside the MINLP's long run.

The search that the others are compared with is the scenario's own, since in space nobody tries every pattern ten times.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.document import document
from benchmarks.paper import table
from benchmarks.paper.table import MINLP, judge, summarise
from benchmarks.rows import Row
from benchmarks.search.search import ours
from gaitflow.config.scenario import Scenario

NOTES = (
    "minlp: the runs of `gaitflow bench minlp`, on tasks of the grid and not on the random ones, each with the budget "
    "of its budget_s, against the search of the same task: Bonmin is not run for ten times that. Absent until then.",
    "guided (or patterns): the scenario's own search of the task, cold, alone; what the others are compared with.",
    *table.NOTES,
)


def run(
    scenario: Scenario,
    artifact: Path,
    long_runs: Mapping[str, Any] | None = None,
    tasks: int = 10,
    seed: int = 0,
    runs: Path = Path("runs"),
) -> Row:
    """The document: a row a task and method; rows measured before, kept below `runs`, are reused.

    `long_runs` is the document of `bench.minlp` on this scenario. Raises ValueError when it is of another problem, and
    as `table.draw_tasks` does.
    """
    of_minlp = [] if long_runs is None else [row for row in long_runs["rows"] if row["method"] == MINLP]
    if any(row["problem"] != scenario.problem_digest for row in of_minlp):
        raise ValueError(
            f"the runs of the MINLP are of {scenario.name} with other settings than it has now: run "
            f"`gaitflow bench minlp --scenario {scenario.name}` again, or remove its document"
        )
    chosen, warm_up = table.draw_tasks(scenario, artifact, tasks, seed)
    measured = table.references("table2", scenario, ours(scenario), chosen, runs)
    measured += table.fixed_gaits("table2", scenario, artifact, chosen, warm_up, seed, runs)
    rows = [*of_minlp, *judge(measured, scenario)]
    return document("table2", scenario.name, rows, summarise(rows), NOTES)
