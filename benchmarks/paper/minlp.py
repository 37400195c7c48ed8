"""The paper's MINLP given an hour by Bonmin, beside our own search of the same task.

The plane's problem takes Bonmin half a minute; of one task in space the paper reports hours. So here are single runs,
with incumbents, best bound and gap told whether or not they end.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks import child
from benchmarks.document import document
from benchmarks.paper import table
from benchmarks.paper.bonmin_log import BonminLog, read_log
from benchmarks.paper.table import MINLP, judge, reaches, summarise
from benchmarks.rows import Row, RowStore
from benchmarks.search import logged_search
from benchmarks.search import search as searching
from benchmarks.search.search import bonmin, ours, search
from benchmarks.search.tasks import middle, spread_tasks, task_key, task_of, task_values
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, gait_of
from gaitflow.core.names import gait_name
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.tables.solver_code import SOLVER_SOURCES, package_digest

BUDGET_S = 3600.0  # CPU time of one run by Bonmin's clock, so at least as much wall time
# Wall over CPU time from which a run counts as hung: a busy machine may give it a sixth of a core.
MOST_WALL_PER_CPU = 6.0
MARGIN_S = 300.0  # for building, the last node and the polish
# What a run of an hour depends on: all but our own search and solver, which only polish the pattern that it ends with.
OUR_OWN = ("search/*.py", "solvers/*.py")
BONMIN_SOURCES = (
    *(each for each in SOLVER_SOURCES if each not in OUR_OWN),
    *("search/bonmin.py", "search/starts.py", "solvers/ipopt.py"),
)
NOTES = (
    "minlp: one run by Bonmin from a random start on the big-M form, with the scenario's stance rows; the pattern that "
    "it ends with is polished in bounds form. cost, gait, pattern, violation: of the polished motion, null unless our "
    "check finds it feasible. objective: of Bonmin's own best point, unscaled as all here. budget_s is CPU time. A run "
    "with the status lost crashed or was ended from outside; what its log told until then stands.",
    "bound: Bonmin's 'best possible'; gap = (objective - bound) / objective. On this nonconvex problem a node's value "
    "is that of a local solution, so that it is no bound in the strict sense, and a completed run no proof.",
    "nodes: of the tree. programs: nonlinear programs that the log counts, those of strong branching too; "
    "failed_programs: those that IPOPT did not solve, whose nodes are dropped. relaxation: the root's value.",
    "incumbents: improvements in the order found, with the CPU time by Bonmin's clock. reached_search_s: when the "
    "first was at most 0.1 % above the search's cost.",
    f"Bonmin's options beyond those of the strategy bonmin: {logged_search.OPTIONS}.",
    "guided or patterns: the scenario's own search of the same task, cold, after Bonmin's run; its time is all of it, "
    "with building. cost_above_rel = (minlp - search) / search, null where one of them found no motion. consistent: "
    "Bonmin's cost is at most 0.1 % above the search's, or as bench table1 says of a gait's patterns.",
)


def run(scenario: Scenario, tasks: int = 1, seed: int = 0, runs: Path = Path("runs")) -> Row:
    """The document: two rows a task; what was measured before, kept below `runs`, is reused.

    One task is the middle of the grid, more are spread over it. Raises ValueError when the grid has fewer.
    """
    chosen = spread_tasks(scenario, tasks, seed) if tasks > 1 else (middle(scenario),)
    measured = _bonmin_runs(scenario, chosen, seed, runs)
    measured += table.references("minlp", scenario, ours(scenario), chosen, runs)
    scale = transcribe(scenario).cost_scale
    rows = [
        judged if judged["method"] != MINLP else judged | _about_bonmin(scenario, judged, read_log(row["log"]), scale)
        for row, judged in zip(measured, judge([_named(row, scenario) for row in measured], scenario), strict=True)
    ]
    return document("minlp", scenario.name, rows, _summary(rows), NOTES)


def _bonmin_runs(scenario: Scenario, tasks: Sequence[Task], seed: int, runs: Path) -> list[Row]:
    solving = {"budget_s": BUDGET_S, "code": package_digest(BONMIN_SOURCES), "casadi": version("casadi")}
    store = RowStore("minlp", scenario, runs, [searching, logged_search], solving=solving)
    keys = [task_key(scenario, task) | {"method": MINLP, "seed": seed} for task in tasks]
    with TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        setup = {"scenario": bonmin(scenario, BUDGET_S).as_data(), "log": str(log)}
        with child.Child("benchmarks.search.logged_search:LoggedSearch", setup) as process:

            def measure(key: Row) -> Row:
                log.unlink(missing_ok=True)
                limit = MOST_WALL_PER_CPU * BUDGET_S + MARGIN_S
                found = search(process, task_values(scenario, key), key["seed"], limit)
                return found | {"log": log.read_text("utf-8", errors="replace") if log.exists() else ""}

            return store.rows(keys, measure)


def _named(row: Row, scenario: Scenario) -> Row:
    """The row with today's name of its gait: names may change while a run of an hour stays what it was."""
    if row["pattern"] is None:
        return row
    gait = gait_of(Pattern.from_text(row["pattern"]), scenario.symmetry(task_of(scenario, row)))
    return row | {"gait": gait_name(gait, scenario.robot.leg_names)}


def _about_bonmin(scenario: Scenario, judged: Mapping[str, Any], log: BonminLog, cost_scale: float) -> Row:
    def unscaled(objective: float | None) -> float | None:
        return None if objective is None else objective * cost_scale

    cost, reference = judged["cost"], judged["reference_cost"]
    reached = (each.time_s for each in log.incumbents if reaches(each.objective * cost_scale, reference))
    return {
        "problem": scenario.problem_digest,
        "budget_s": BUDGET_S,
        "cost_above_rel": None if cost is None or reference is None else (cost - reference) / reference,
        "objective": unscaled(log.best),
        "bound": unscaled(log.bound),
        "gap": log.gap,
        "relaxation": unscaled(log.relaxation),
        "completed": log.completed,
        "nodes": log.nodes,
        "programs": log.programs,
        "failed_programs": log.failed_programs,
        "first_incumbent_s": log.incumbents[0].time_s if log.incumbents else None,
        "reached_search_s": next(reached, None),
        "incumbents": [
            {
                "time_s": each.time_s,
                "objective": unscaled(each.objective),
                "nodes": each.nodes,
                "found_by": each.found_by,
            }
            for each in log.incumbents
        ],
    }


def _summary(rows: Sequence[Mapping[str, Any]]) -> Row:
    """The tables' columns, an object a method, and how far Bonmin came at worst."""
    of_bonmin = [row for row in rows if row["method"] == MINLP]

    def worst(key: str) -> float | None:
        return max((row[key] for row in of_bonmin if row[key] is not None), default=None)

    return summarise(rows) | {
        "budget_s": BUDGET_S,
        "completed": sum(row["completed"] for row in of_bonmin),
        "nodes": sum(row["nodes"] for row in of_bonmin),
        "gap": worst("gap"),
        "cost_above_rel": worst("cost_above_rel"),
        "first_incumbent_s": worst("first_incumbent_s"),
    }
