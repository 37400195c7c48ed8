"""What Tables I and II of the paper have in common: random tasks off the grid, the picked gait, who was consistent.

The gait is the classifier's pick, as in the paper. What is consistent is judged against a search of the same task.
"""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import child
from benchmarks.paper import big_m, fixed_gait
from benchmarks.rows import Row, RowStore
from benchmarks.search import search as searching
from benchmarks.search.search import OURS, search
from benchmarks.search.tasks import task_key, task_of, task_values
from gaitflow.config.scenario import Scenario
from gaitflow.core.domain import Domain
from gaitflow.core.gaits import Pattern, representative
from gaitflow.core.task import Task
from gaitflow.files import sha256_file
from gaitflow.runtime import GaitMap, atlas, gait_map, nearby, plan, problem, refine, rivals
from gaitflow.runtime.versions import resolve
from gaitflow.solvers import interior_point, kkt, options

MINLP = "minlp"
SAME_OPTIMUM = 1e-3  # relative cost
SEARCH_LIMIT_S = 4 * 3600.0
DRAWS_PER_TASK = 1000
NOTES = (
    "bigm_random: the gait fixed in the paper's big-M form, random start (the paper's 'gait pattern only'). "
    "bounds_random: the gait fixed by variable bounds, the same start. bounds_mean: from the mean motion of the gait's "
    "region (the paper's 'gait pattern & state'). bounds_mean_dual: GaitMap.plan, mean motion and multipliers.",
    "Times are CPU times of one single-threaded call after its solver was built and called once, measured one after "
    "the other in one process, so that other work on the machine does not enter; wall_mean_s stands beside. Those of "
    "a search include building. Failed runs and time limits count with the time that they took. "
    f"Limits: the scenario's a call, {big_m.MAX_ITERATIONS} iterations for big-M. "
    "build_s is the wall time of transcription, building the solver and its first call.",
    "successful: the solver converged and our check finds no violation above 1e-6, the same for all methods.",
    "consistent: the cost is at most 0.1 % above the search's best, or the gait is its best gait and the cost at most "
    "0.1 % above the best of the pattern that realises it. consistent_pattern: the cost is at most 0.1 % above the "
    "best known of the run's own pattern, the search's or, where it did not try that, of all methods; whether or not "
    "it is the best pattern. better: the cost is more than 0.1 % below the search's best. The paper compares with the "
    "MINLP and prints N/A for it; here the search is compared with, and has the N/A.",
)


def draw_tasks(scenario: Scenario, artifact: Path, tasks: int, seed: int) -> tuple[list[Task], Task]:
    """Random tasks inside a map's domain and off its grid, and one more to warm up with.

    Raises ArtifactError, and ValueError when the artifact is of another problem than the scenario, when its domain has
    no inside, or for less than 1 task.
    """
    if tasks < 1:
        raise ValueError(f"tasks = {tasks}: must be at least 1")
    made_for = fixed_gait.scenario_of(artifact)
    if made_for.problem_digest != scenario.problem_digest:
        raise ValueError(
            f"{artifact}: was made for {made_for.name} with other settings than {scenario.name} has now; publish again"
        )
    domain = GaitMap.load(artifact).manifest.domain
    *chosen, warm_up = (scenario.tasks.space.task(at, "held_out") for at in off_grid_places(domain, tasks + 1, seed))
    return chosen, warm_up


def off_grid_places(domain: Domain, count: int, seed: int) -> tuple[dict[str, float], ...]:
    """Random places inside a domain, their values by axis, uniform, in the order drawn.

    None shares a value with the grid on an axis that has several. Raises ValueError when there is no such place.
    """
    rng = np.random.default_rng(seed)
    low, high = ([values[end] for values in domain.axes.values()] for end in (0, -1))
    drawn: list[dict[str, float]] = []
    for _ in range(DRAWS_PER_TASK * count):
        values = (round(float(x), 6) for x in rng.uniform(low, high))
        place = dict(zip(domain.axes, values, strict=True))
        on_line = any(len(grid) > 1 and place[axis] in grid for axis, grid in domain.axes.items())
        if not on_line and domain.contains(place):
            drawn.append(place)
        if len(drawn) == count:
            return tuple(drawn)
    raise ValueError(
        f"found {len(drawn)} of {count} tasks between {low} and {high} ({', '.join(domain.axes)}) inside the map's "
        "domain: a domain without a whole grid cell has no tasks off its grid"
    )


def references(bench: str, scenario: Scenario, searched: Scenario, tasks: Sequence[Task], runs: Path) -> list[Row]:
    """A row a task: searched by the strategy of `searched`, cold, each anew."""
    keys = [task_key(scenario, task) | {"method": searched.strategy.name, "seed": None} for task in tasks]
    with child.Child("benchmarks.search.search:Search", {"scenario": searched.as_data()}) as process:
        return RowStore(bench, scenario, runs, [searching]).rows(
            keys, lambda key: search(process, task_values(scenario, key), None, SEARCH_LIMIT_S)
        )


def fixed_gaits(
    bench: str, scenario: Scenario, artifact: Path, tasks: Sequence[Task], warm_up: Task, seed: int, runs: Path
) -> list[Row]:
    """A row a task and method of `fixed_gait`."""
    keys: list[Row] = [
        task_key(scenario, task) | {"method": method, "seed": seed} for task in tasks for method in fixed_gait.METHODS
    ]
    about = {"manifest": sha256_file(resolve(artifact) / "manifest.json")}
    modules = [fixed_gait, big_m, atlas, nearby, gait_map, interior_point, kkt, plan, problem, refine, rivals, options]
    limit = 10 * scenario.strategy.solve_time_limit  # wall time: the machine may be busy
    setup = {"artifact": str(artifact), "warm_up": task_key(scenario, warm_up)}
    with child.Child("benchmarks.paper.fixed_gait:FixedGait", setup) as planner:

        def measure(key: Row) -> Row:
            try:
                call = {"method": key["method"], "task": task_values(scenario, key), "seed": key["seed"]}
                return dict(planner.call(limit, **call))
            except child.Lost as lost:
                nothing = dict.fromkeys(("gait", "pattern", "cost", "violation", "iterations", "build_s"))
                return {
                    **nothing, "status": searching.LOST, "solver_status": str(lost),
                    "wall_s": lost.wall_s, "cpu_s": lost.cpu_s,
                }  # fmt: skip

        return RowStore(bench, scenario, runs, modules, about).rows(keys, measure)


def judge(measured: Sequence[Row], scenario: Scenario) -> list[Row]:
    """Every row with successful, consistent, consistent_pattern and better; see NOTES for what they mean.

    The rows of a search, one a task, are what the others of their task are compared with.
    """
    searched = {task_of(scenario, row): row for row in measured if row["method"] in OURS}
    best_known = _best_known(measured, scenario)
    rows = []
    for row in measured:
        task = task_of(scenario, row)
        reference = searched[task]
        own = best_known.get((task, _cyclic(row, scenario)))
        best, cost = reference["cost"], row["cost"]
        at_best, at_own = reaches(cost, best), reaches(cost, own)
        shown = {key: value for key, value in row.items() if key not in ("costs", "counts", "whole_wall_s", "log")}
        rows.append(
            shown
            | {
                "time_s": row["whole_cpu_s"] if row is reference else row["cpu_s"],
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
    """One object a method that has rows, in the tables' order."""
    methods = {row["method"] for row in rows}
    ordered = [method for method in (MINLP, *fixed_gait.METHODS, *OURS) if method in methods]
    return {method: _summary([row for row in rows if row["method"] == method], method) for method in ordered}


def _summary(rows: Sequence[Mapping[str, Any]], method: str) -> Row:
    times = [row["time_s"] for row in rows]
    reference = method in OURS
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


def _cyclic(row: Mapping[str, Any], scenario: Scenario) -> str | None:
    if row["pattern"] is None:
        return None
    symmetry = scenario.symmetry(task_of(scenario, row))
    return representative(Pattern.from_text(row["pattern"]), symmetry).text


def _best_known(measured: Sequence[Row], scenario: Scenario) -> dict[tuple[Task, str | None], float]:
    """The least cost of each task and pattern: the search's, else the others' where at least two found one."""
    found: dict[tuple[Task, str | None], list[float]] = defaultdict(list)
    for row in measured:
        if row["method"] not in OURS and row["cost"] is not None:
            found[task_of(scenario, row), _cyclic(row, scenario)].append(row["cost"])
    known = {key: min(costs) for key, costs in found.items() if len(costs) > 1}
    for row in measured:
        if row["method"] in OURS:
            known |= {(task_of(scenario, row), pattern): cost for pattern, cost in row["costs"].items()}
    return known
