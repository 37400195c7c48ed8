"""The paper's MINLP given an hour by Bonmin, beside our own search of the same task.

The plane's problem takes Bonmin half a minute; of one task in space the paper reports hours. So here are single runs,
with incumbents, best bound and gap told whether or not they end.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gaitflow
from gaitflow.bench import logged_search
from gaitflow.bench import search as searching
from gaitflow.bench.bonmin_log import BonminLog, read_log
from gaitflow.bench.child import Child
from gaitflow.bench.discovery import spread_tasks
from gaitflow.bench.document import document
from gaitflow.bench.rows import Row, RowStore
from gaitflow.bench.search import bonmin, ours, search
from gaitflow.bench.table1 import reaches
from gaitflow.dataset.units import source_digest
from gaitflow.gait_names import gait_name
from gaitflow.gaits import Pattern, gait_of
from gaitflow.problem import transcribe
from gaitflow.scenario import Scenario
from gaitflow.task import Task

BUDGET_S = 3600.0  # CPU time of one run by Bonmin's clock, so at least as much wall time
MARGIN_S = 300.0  # for building, the last node and the polish
OUR_LIMIT_S = 4 * 3600.0
# What a run of an hour depends on; our own search may change without it.
BONMIN_SOURCES = ("problem/*.py", "solve/bonmin.py", "solve/nlp.py", "solve/guess.py", "check.py", "trajectory.py")
NOTES = (
    "bonmin: one run from a random start on the big-M form, with the scenario's stance rows; the pattern that it ends "
    "with is polished in bounds form. cost, gait, pattern, violation: of the polished motion, null unless our check "
    "finds it feasible. objective: of Bonmin's own best point, unscaled as all here.",
    "bound: Bonmin's 'best possible'; gap = (objective - bound) / objective. On this nonconvex problem a node's value "
    "is that of a local solution, so that it is no bound in the strict sense, and a completed run no proof.",
    "nodes: of the tree. programs: nonlinear programs solved in all, with strong branching and heuristics; "
    "failed_programs: those that IPOPT did not solve, whose nodes are dropped. relaxation: the root's value.",
    "incumbents: improvements in the order found, with the CPU time by Bonmin's clock. reached_ours_s: when the first "
    "was at most 0.1 % above our cost. budget_s is CPU time. A lost run crashed or was ended from outside; what its "
    "log told until then stands.",
    f"Bonmin's options beyond those of the strategy bonmin: {logged_search.OPTIONS}.",
    "ours: the scenario's own search of the same task, cold, after Bonmin's run; cpu_s is all of it, with building. "
    "cost_worse_rel = (ours - bonmin) / bonmin, null where one of them found no motion. consistent: Bonmin's cost is "
    "at most 0.1 % above ours.",
)


def run(scenario: Scenario, tasks: int = 1, seed: int = 0, runs: Path = Path("runs")) -> Row:
    """The document: a row a task; what was measured before, kept below `runs`, is reused.

    One task is the middle of the grid, more are spread over it. Raises ValueError when the grid has fewer.
    """
    chosen = spread_tasks(scenario, tasks, seed) if tasks > 1 else (middle(scenario),)
    keys = [{"speed": task.speed, "cycle_duration": task.cycle_duration} for task in chosen]
    theirs = _bonmin_runs(scenario, [key | {"method": "bonmin", "seed": seed} for key in keys], runs)
    own = _our_searches(ours(scenario), [key | {"method": ours(scenario).strategy.name} for key in keys], runs)
    scale = transcribe(scenario).cost_scale
    rows = [compare(scenario, *pair, scale) for pair in zip(theirs, own, strict=True)]
    return document("minlp", scenario.name, rows, summarise(rows), NOTES)


def middle(scenario: Scenario) -> Task:
    """The task in the middle of the grid."""
    speeds, durations = scenario.tasks.speed.values, scenario.tasks.cycle_duration.values
    return Task(speeds[len(speeds) // 2], durations[len(durations) // 2])


def compare(scenario: Scenario, theirs: Row, own: Row, cost_scale: float) -> Row:
    """One task: what Bonmin's row and its log tell, and our search beside it."""
    log = read_log(theirs["log"])
    at_ours = [each.time_s for each in log.incumbents if reaches(each.objective * cost_scale, own["cost"])]
    found = theirs["cost"] is not None and own["cost"] is not None
    return {
        "speed": theirs["speed"],
        "cycle_duration": theirs["cycle_duration"],
        "bonmin": _found(scenario, theirs)
        | {"cpu_s": theirs["cpu_s"], "wall_s": theirs["wall_s"], "budget_s": BUDGET_S}
        | _told(log, cost_scale)
        | {"reached_ours_s": min(at_ours, default=None)},
        "ours": {"strategy": own["method"]}
        | _found(scenario, own)
        | {"solves": own["solves"], "counts": own["counts"]}
        | {"cpu_s": own["whole_cpu_s"], "wall_s": own["whole_wall_s"]},
        "cost_worse_rel": (own["cost"] - theirs["cost"]) / theirs["cost"] if found else None,
    }


def summarise(rows: Sequence[Mapping[str, Any]]) -> Row:
    """One object a method: Table II's columns, and for Bonmin how far it came (the worst of all rows)."""

    def worst(method: str, key: str) -> float | None:
        return max((row[method][key] for row in rows if row[method][key] is not None), default=None)

    return {
        "minlp": _columns([row["bonmin"] for row in rows])
        | {
            "consistent": sum(reaches(row["bonmin"]["cost"], row["ours"]["cost"]) for row in rows),
            "completed": sum(row["bonmin"]["completed"] for row in rows),
            "gap": worst("bonmin", "gap"),
            "nodes": sum(row["bonmin"]["nodes"] for row in rows),
            "first_incumbent_s": worst("bonmin", "first_incumbent_s"),
        },
        "ours": _columns([row["ours"] for row in rows])
        | {"cost_worse_rel": max((r["cost_worse_rel"] for r in rows if r["cost_worse_rel"] is not None), default=None)},
    }


def _bonmin_runs(scenario: Scenario, keys: Sequence[Row], runs: Path) -> list[Row]:
    package = Path(gaitflow.__file__).parent
    code = source_digest({str(path): path.read_text("utf-8") for each in BONMIN_SOURCES for path in package.glob(each)})
    solving = {"budget_s": BUDGET_S, "code": code, "casadi": version("casadi")}
    store = RowStore("minlp", scenario, runs, [searching, logged_search], solving=solving)
    with TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        setup = {"scenario": bonmin(scenario, BUDGET_S).as_data(), "log": str(log)}
        with Child("gaitflow.bench.logged_search:LoggedSearch", setup) as child:

            def measure(key: Row) -> Row:
                log.unlink(missing_ok=True)
                # The machine may be busy, and Bonmin's clock counts CPU time.
                found = search(child, key["speed"], key["cycle_duration"], key["seed"], 3 * BUDGET_S + MARGIN_S)
                return found | {"log": log.read_text("utf-8", errors="replace") if log.exists() else ""}

            return store.rows(keys, measure)


def _our_searches(scenario: Scenario, keys: Sequence[Row], runs: Path) -> list[Row]:
    with Child("gaitflow.bench.search:Search", {"scenario": scenario.as_data()}) as child:
        return RowStore("minlp", scenario, runs, [searching]).rows(
            keys, lambda key: search(child, key["speed"], key["cycle_duration"], None, OUR_LIMIT_S)
        )


def _found(scenario: Scenario, row: Row) -> Row:
    # The name is not the row's own: gaits may be named anew while a run of an hour stays what it was.
    robot = scenario.robot
    mirror = robot.mirror_permutation if robot.mirror else None
    gait = gait_of(Pattern.from_text(row["pattern"]), mirror) if row["pattern"] is not None else None
    return {
        "status": row["status"],
        "solver_status": row["solver_status"],
        "gait": gait_name(gait, robot.leg_names) if gait is not None else None,
        **{key: row[key] for key in ("pattern", "cost", "violation")},
    }


def _told(log: BonminLog, cost_scale: float) -> Row:
    def unscaled(objective: float | None) -> float | None:
        return None if objective is None else objective * cost_scale

    incumbents = [
        {"time_s": each.time_s, "objective": unscaled(each.objective), "nodes": each.nodes, "found_by": each.found_by}
        for each in log.incumbents
    ]
    return {
        "objective": unscaled(log.best),
        "bound": unscaled(log.bound),
        "gap": log.gap,
        "relaxation": unscaled(log.relaxation),
        "completed": log.completed,
        "nodes": log.nodes,
        "programs": log.programs,
        "failed_programs": log.failed_programs,
        "first_incumbent_s": incumbents[0]["time_s"] if incumbents else None,
        "incumbents": incumbents,
    }


def _columns(results: Sequence[Mapping[str, Any]]) -> Row:
    times = [result["cpu_s"] for result in results]
    return {
        "time_mean_s": statistics.fmean(times),
        "time_std_s": statistics.stdev(times) if len(times) > 1 else 0.0,
        "wall_mean_s": statistics.fmean(result["wall_s"] for result in results),
        "successful": sum(result["cost"] is not None for result in results),
        "runs": len(results),
    }
