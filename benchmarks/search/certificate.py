"""Is the gait of a label the best there is? Exhaustive search of some tasks, as a certificate for a guided map.

Every pattern that the scenario allows is ruled out by a sound bound on its cost, or solved. The units are planned,
stored and resumed like those of a map.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.document import document
from benchmarks.rows import Row
from benchmarks.search.tasks import spread_tasks, task_key, task_of
from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.dataset.labels import gait_costs
from gaitflow.execute.local import local_client
from gaitflow.execute.progress import progress
from gaitflow.execute.run import run_units
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit, plan_exhaustive
from gaitflow.tables.schema import scalar_columns, solution_schema

WORKERS = 2
PARTS = 4  # units that one task is cut into
DRAWN = 8  # tasks spread over the grid together
WITHIN = 1e-3  # relative cost up to which the label stands
NOTES = (
    "patterns: all that the scenario allows, one for each set of patterns that differ by where the cycle is cut or by "
    "left and right. Each is ruled out (a leg that never swings or no leg that ever stands; stance travel and swing "
    "speed that do not fit into the cycle; a floor of its cost above the label's cost) or solved from the nominal "
    "start; the three best gaits of each quarter of the patterns also from other starts.",
    "gap_rel = (label - exhaustive) / exhaustive: positive where the exhaustive search found a cheaper motion. The "
    "label's own pattern is among those solved; a negative gap says that its solve here ended in a dearer local "
    "optimum. undecided: patterns whose solves failed without a verdict. certified: the label is at most "
    f"{WITHIN:.1%} above the exhaustive search, which solved its gait, too, and nothing is undecided.",
    "A pattern counts as infeasible when the solver ended at a point of local infeasibility: on this nonconvex "
    "problem that, as every cost, is a local statement. The bound is none: what it rules out cannot be cheaper.",
)


def run(scenario: Scenario, labels: pd.DataFrame, tasks: int = 6, seed: int = 0, runs: Path = Path("runs")) -> Row:
    """The document: a row a task, spread over the grid; solved units below `runs` are reused.

    `labels` are the scenario's. Raises ValueError when the grid has fewer tasks, or when no chosen one is labelled.
    """
    grid = labels[(labels["split"] == "grid") & (labels["status"] == "solved")]
    known = {task_of(scenario, row): row for row in grid.to_dict("records")}
    # Of one draw the first few: more tasks keep those that were searched before.
    drawn = spread_tasks(scenario, min(max(tasks, DRAWN), len(grid)), seed)[:tasks]
    chosen = [task for task in drawn if task in known]
    if not chosen:
        raise ValueError(f"{scenario.name}: none of the {tasks} chosen tasks has a label; choose more")
    incumbents = {task: float(known[task]["cost"]) for task in chosen}
    units = plan_exhaustive(scenario, incumbents, PARTS)
    store = UnitStore(runs / "bench" / f"certificate-{scenario.name}")
    with progress(f"certificate {scenario.name}") as on_event:
        run_units(units, store, lambda: local_client(WORKERS), on_event)
    rows = [
        task_key(scenario, task) | compare(known[task], solves_of(store, units, task), scenario.robot.leg_names)
        for task in chosen
    ]
    summary = {"problem": scenario.problem_digest} | summarise(rows)
    return document("certificate", scenario.name, rows, summary, NOTES)


def solves_of(store: UnitStore, units: Sequence[Unit], task: Task) -> pd.DataFrame:
    """The scalar columns of all stored rows of a task."""
    own = [unit for unit in units if unit.tasks == (task,)]
    columns = scalar_columns(solution_schema(own[0].scenario.as_data()).names)
    return pd.concat([store.read(unit, columns=columns).to_pandas() for unit in own], ignore_index=True)


def compare(label: Mapping[Any, Any], solves: pd.DataFrame, leg_names: Sequence[str]) -> Row:
    """One task: its label beside the best of all patterns, and what became of each."""
    costs = gait_costs(solves, leg_names)
    best = None if costs.empty else costs.iloc[0]
    reasons = Counter(
        "dearer" if reason.startswith("costs at least") else "impossible"
        for reason in solves.loc[solves["status"] == "screened", "solver_status"]
    )
    statuses = solves["status"].value_counts()
    gap = None if best is None else float((label["cost"] - best["cost"]) / best["cost"])
    undecided = int(statuses.get("failed", 0))
    return {
        "label": {key: label[key] for key in ("gait", "pattern", "cost")},
        "exhaustive": {key: None if best is None else best[key] for key in ("gait", "pattern", "cost")},
        "gap_rel": gap,
        "same_gait": best is not None and best["gait"] == label["gait"],
        "certified": undecided == 0 and label["gait"] in set(costs["gait"]) and gap is not None and gap <= WITHIN,
        "patterns": len(solves),
        "impossible": reasons["impossible"],
        "dearer": reasons["dearer"],
        "solved": int(statuses.get("solved", 0)),
        "infeasible": int(statuses.get("infeasible", 0)),
        "undecided": undecided,
        "solves": int(solves["solves"].sum()),
        "cpu_s": float(solves["cpu_s"].sum()),
    }


def summarise(rows: Sequence[Row]) -> Row:
    """The worst gap, how many labels stand, and what it took."""
    gaps = [row["gap_rel"] for row in rows if row["gap_rel"] is not None]
    return {
        "tasks": len(rows),
        "certified": sum(row["certified"] for row in rows),
        "same_gait": sum(row["same_gait"] for row in rows),
        "gap_max_rel": max(gaps, default=None),
        "gap_min_rel": min(gaps, default=None),
        "undecided": sum(row["undecided"] for row in rows),
        "patterns_per_task": max(row["patterns"] for row in rows),
        "ruled_out_share": sum(row["impossible"] + row["dearer"] for row in rows)
        / sum(row["patterns"] for row in rows),
        "cpu_s": sum(row["cpu_s"] for row in rows),
    }
