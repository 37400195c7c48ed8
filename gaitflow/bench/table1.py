"""Table I of the paper: time, successful runs and consistency of the MINLP and of optimising a picked gait; and ours.

Random tasks inside the map's domain and off its grid. The gait is the classifier's pick, as in the paper.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.bench import big_m, child, fixed_gait
from gaitflow.bench import search as searching
from gaitflow.bench.document import document
from gaitflow.bench.rows import Row, RowStore
from gaitflow.bench.search import BONMIN_LIMIT_S, bonmin, patterns, search
from gaitflow.files import sha256_file
from gaitflow.gaits import Pattern, representative
from gaitflow.runtime import GaitMap, gait_map, plan, refine, solver_options
from gaitflow.runtime.domain import Domain
from gaitflow.runtime.versions import resolve
from gaitflow.scenario import Scenario
from gaitflow.task import Task

METHODS = ("minlp", *fixed_gait.METHODS, "patterns")
SAME_OPTIMUM = 1e-3  # relative cost
SEARCH_LIMIT_S = 3600.0
DRAWS_PER_TASK = 1000
NOTES = (
    "minlp: one Bonmin run from a random start, polished in bounds form. bigm_random: the gait fixed in the paper's "
    "big-M form, random start (the paper's 'gait pattern only'). bounds_random: the gait fixed by variable bounds, "
    "the same start. bounds_mean: from the mean motion of the gait's region (the paper's 'gait pattern & state'). "
    "bounds_mean_dual: GaitMap.plan, mean motion and multipliers. patterns: every pattern of the task searched, cold.",
    "Times are CPU times of one single-threaded call after its solver was built and called once, measured one after "
    "the other in one process, so that other work on the machine does not enter; wall_mean_s stands beside. Those of "
    "patterns include building. Failed runs and time limits count with the time that they took. "
    f"Limits: the scenario's a call, {BONMIN_LIMIT_S:g} s for Bonmin, {big_m.MAX_ITERATIONS} iterations for big-M. "
    "build_s is the wall time of transcription, building the solver and its first call.",
    "successful: the solver converged and our check finds no violation above 1e-6, the same for all methods.",
    "consistent: the optimum of the exhaustive search by patterns: the cost is at most 0.1 % above its best, or the "
    "gait is its best gait and the cost at most 0.1 % above the best of the pattern that realises it. "
    "consistent_pattern: the cost is at most 0.1 % above the best known of the run's own pattern, whether or not that "
    "is the best pattern. better: the cost is more than 0.1 % below the search's best. The paper compares with the "
    "MINLP and prints N/A for it; here the search is compared with, and has the N/A.",
)


def run(
    scenario: Scenario, artifact: Path, tasks: int = 10, restarts: int = 1, seed: int = 0, runs: Path = Path("runs")
) -> Row:
    """The document: a row a task, method and restart; rows measured before, kept below `runs`, are reused.

    `restarts` are Bonmin runs a task. Raises ArtifactError, and ValueError when the artifact is of another problem than
    the scenario, when its domain has no inside, or for less than 1 task or restart.
    """
    if tasks < 1 or restarts < 1:
        raise ValueError(f"tasks = {tasks}, restarts = {restarts}: must be at least 1 each")
    made_for = fixed_gait.scenario_of(artifact)
    if made_for.problem_digest != scenario.problem_digest:
        raise ValueError(
            f"{artifact}: was made for {made_for.name} with other settings than {scenario.name} has now; publish again"
        )
    *chosen, warm_up = off_grid_tasks(GaitMap.load(artifact).manifest.domain, tasks + 1, seed)
    measured = _searches(scenario, chosen, restarts, seed, runs) + _fixed_gaits(
        scenario, artifact, chosen, warm_up, seed, runs
    )
    rows = judge(measured, scenario)
    return document("table1", scenario.name, rows, summarise(rows), NOTES)


def off_grid_tasks(domain: Domain, count: int, seed: int) -> tuple[Task, ...]:
    """Random tasks inside a domain, uniform, in the order drawn. Raises ValueError when it has no inside."""
    rng = np.random.default_rng(seed)
    low = (domain.speeds[0], domain.cycle_durations[0])
    high = (domain.speeds[-1], domain.cycle_durations[-1])
    drawn: list[Task] = []
    for _ in range(DRAWS_PER_TASK * count):
        speed, duration = (round(float(x), 6) for x in rng.uniform(low, high))
        on_line = speed in domain.speeds or duration in domain.cycle_durations
        if not on_line and domain.contains(speed, duration):
            drawn.append(Task(speed, duration, "held_out"))
        if len(drawn) == count:
            return tuple(drawn)
    raise ValueError(
        f"found {len(drawn)} of {count} tasks between {low} and {high} (speed, cycle duration) inside the map's "
        "domain: a domain without a whole grid cell has no tasks off its grid"
    )


def _searches(scenario: Scenario, tasks: Sequence[Task], restarts: int, seed: int, runs: Path) -> list[Row]:
    keys: list[Row] = []
    for task in tasks:
        where = {"speed": task.speed, "cycle_duration": task.cycle_duration}
        keys.append({**where, "method": "patterns", "seed": None})
        keys += [{**where, "method": "minlp", "seed": seed + number} for number in range(restarts)]
    store = RowStore("table1", scenario, runs, [searching])
    with (
        child.Child("gaitflow.bench.search:Search", {"scenario": patterns(scenario).as_data()}) as ours,
        child.Child("gaitflow.bench.search:Search", {"scenario": bonmin(scenario).as_data()}) as theirs,
    ):

        def measure(key: Row) -> Row:
            if key["method"] == "patterns":
                return search(ours, key["speed"], key["cycle_duration"], None, SEARCH_LIMIT_S)
            return search(theirs, key["speed"], key["cycle_duration"], key["seed"], 3 * BONMIN_LIMIT_S)

        return store.rows(keys, measure)


def _fixed_gaits(
    scenario: Scenario, artifact: Path, tasks: Sequence[Task], warm_up: Task, seed: int, runs: Path
) -> list[Row]:
    keys: list[Row] = [
        {"speed": task.speed, "cycle_duration": task.cycle_duration, "method": method, "seed": seed}
        for task in tasks
        for method in fixed_gait.METHODS
    ]
    about = {"manifest": sha256_file(resolve(artifact) / "manifest.json")}
    modules = [fixed_gait, big_m, gait_map, plan, refine, solver_options]
    limit = 10 * scenario.strategy.solve_time_limit  # wall time: the machine may be busy
    setup = {"artifact": str(artifact), "warm_up": [warm_up.speed, warm_up.cycle_duration]}
    with child.Child("gaitflow.bench.fixed_gait:FixedGait", setup) as planner:

        def measure(key: Row) -> Row:
            try:
                return dict(planner.call(limit, **key))
            except child.Lost as lost:
                nothing = dict.fromkeys(("gait", "pattern", "cost", "violation", "iterations", "build_s"))
                return {
                    **nothing, "status": searching.LOST, "solver_status": str(lost),
                    "wall_s": lost.wall_s, "cpu_s": lost.cpu_s,
                }  # fmt: skip

        return RowStore("table1", scenario, runs, modules, about).rows(keys, measure)


def judge(measured: Sequence[Row], scenario: Scenario) -> list[Row]:
    """Every row with successful, consistent, consistent_pattern and better; see NOTES for what they mean."""
    robot = scenario.robot
    mirror = robot.mirror_permutation if robot.mirror else None
    references = {(row["speed"], row["cycle_duration"]): row for row in measured if row["method"] == "patterns"}
    rows = []
    for row in measured:
        reference = references[row["speed"], row["cycle_duration"]]
        own = None
        if row["pattern"] is not None:
            own = reference["costs"].get(representative(Pattern.from_text(row["pattern"]), mirror).text)
        best, cost = reference["cost"], row["cost"]
        at_best, at_own = reaches(cost, best), reaches(cost, own)
        shown = {key: value for key, value in row.items() if key not in ("costs", "counts", "whole_wall_s")}
        rows.append(
            shown
            | {
                "time_s": row["whole_cpu_s"] if row["method"] == "patterns" else row["cpu_s"],
                "successful": cost is not None,
                "consistent": at_best or (at_own and row["gait"] == reference["gait"]),
                "consistent_pattern": at_own,
                "better": cost is not None and best is not None and cost < best * (1 - SAME_OPTIMUM),
                "reference_gait": reference["gait"],
                "reference_cost": best,
                "pattern_cost": own,
            }
        )
    return rows


def summarise(rows: Sequence[Mapping[str, Any]]) -> Row:
    """One object a method, in the order of METHODS."""
    return {method: _summary([row for row in rows if row["method"] == method], method) for method in METHODS}


def _summary(rows: Sequence[Mapping[str, Any]], method: str) -> Row:
    times = [row["time_s"] for row in rows]
    reference = method == "patterns"
    return {
        "time_mean_s": statistics.fmean(times),
        "time_std_s": statistics.stdev(times) if len(times) > 1 else 0.0,
        "time_median_s": statistics.median(times),
        "wall_mean_s": statistics.fmean(row["wall_s"] for row in rows),
        "successful": sum(row["successful"] for row in rows),
        "consistent": None if reference else sum(row["consistent"] for row in rows),
        "consistent_pattern": None if reference else sum(row["consistent_pattern"] for row in rows),
        "better": None if reference else sum(row["better"] for row in rows),
        "runs": len(rows),
        "build_s": next((row["build_s"] for row in rows if row.get("build_s") is not None), None),
    }


def reaches(cost: float | None, best: float | None) -> bool:
    """Whether a cost is known and at most SAME_OPTIMUM above a known best."""
    return cost is not None and best is not None and cost <= best * (1 + SAME_OPTIMUM)
