"""What a planner gets from a map at run time: how long `plan` takes, how good it is, and the paper's way beside it."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import child
from benchmarks.document import document
from benchmarks.paper import table
from benchmarks.paper.random_start import METHODS, PAPER, PLAN, calls_by_method
from benchmarks.paper.table import SAME_OPTIMUM, reaches
from benchmarks.paper.targets import against
from benchmarks.rows import Row
from benchmarks.search.search import ours
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import NO_SYMMETRY, Pattern, Symmetry, gait_of
from gaitflow.runtime import GaitMap

TASKS = {2: 1000, 3: 500}  # by the robot's dimension
REFERENCES, PAPER_TASKS = 64, 20
PLAN_LIMIT_S = 30.0  # wall time of one plan, beyond which the process counts as hung
PARTS = ("select", "predict", "refine")
BINS = 10  # of probability
DIGITS = 6
NOTES = (
    "Tasks are random by `seed`, uniform in the map's domain, off its grid. A row a task: one call of GaitMap.plan in "
    "a process of one thread that had planned one task of each gait before. wall_ms is by the clock around the call, "
    "what else the machine did included, cpu_ms the process's CPU time; select_ms, predict_ms, refine_ms are plan's "
    "own wall times, its check is part of refine_ms. plan_ms_* are of wall_ms, plan_cpu_ms_* of cpu_ms. wall_over_cpu: "
    "the sum of the one over that of the other, 1 on a machine without other work. select_us_*: wall time of select.",
    "path: fast (Newton steps from the prediction), fallback (IPOPT), next:<n> (another gait), cheaper:<n> (another "
    "one, after the first), failed. violation: by our check, feasible when at most 1e-6. picked, only where it is not "
    "plan's gait: what select says. first_as_select_rate: how often plan tries that one first; same_as_select_rate: "
    "how often it is plan's gait in the end.",
    f"reference: the first {REFERENCES} tasks were searched by the scenario's own strategy, cold. excess = (plan's "
    "cost - the search's best) / the search's best. consistent: plan solved the task, and has the search's best gait "
    "or an excess of at most 0.1 %; within: the excess is at most 0.1 %, whatever the gait; better: it is below "
    "-0.1 %. picked_best: select's gait is the search's best. calibration_error: the share of those less the mean of "
    f"select's probability, absolute, by {BINS} bins of probability, weighted by tasks.",
    f"paper: the first {PAPER_TASKS} tasks, each by all methods in turn in another process. bigm_random: the paper's "
    "'gait pattern only', big-M rows from a random start; bounds_random: the gait by variable bounds, the same start; "
    "bounds_mean: from the mean of the gait's region, the paper's warm start. Their gait is the classifier's pick, and "
    "their time that of one solver call; plan's is all of plan, with choosing and checking. successful: solved, by the "
    "same check; optimal: cost at most 0.1 % above the reference's best.",
    "speedup: a method's CPU time over plan's on the same task, the median over tasks; of_medians: the ratio of the "
    "medians; wall_*: the same of wall times. Runs that failed count with the time they took. "
    "speedup_vs_paper_median: of bigm_random.",
    "targets: what was aimed at beside what was found; one without a number to compare is missed.",
)


def run(scenario: Scenario, artifact: Path, tasks: int | None = None, seed: int = 0, runs: Path = Path("runs")) -> Row:
    """The document: a row a task, by default 1,000 in the plane and 500 in space.

    References and the paper's way, measured before and kept below `runs`, are reused; plan is always timed anew.
    Raises child.Lost when plan hangs or ends its process, and as `table.draw_tasks` does.
    """
    dimension = scenario.robot.dimension
    chosen, warm_up_task = table.draw_tasks(scenario, artifact, TASKS[dimension] if tasks is None else tasks, seed)
    references = table.references("online", scenario, ours(scenario), chosen[:REFERENCES], runs)
    paper = calls_by_method("online", scenario, artifact, chosen[:PAPER_TASKS], warm_up_task, seed, runs)
    with child.Child("benchmarks.online.plan_times:PlanTimes", {"artifact": str(artifact)}) as process:
        asked = [{axis: task[axis] for axis in scenario.tasks.space.ranged} for task in chosen]
        timed = process.call(PLAN_LIMIT_S * (1 + len(asked)), tasks=asked)
    rows = judge(timed["rows"], references, paper, [scenario.symmetry(task) for task in chosen])
    summary = summarise(rows, timed["select_us"])
    summary["seed"] = seed
    summary["map_version"] = str(GaitMap.load(artifact).manifest.version)
    summary |= {key: timed[key] for key in ("load_s", "warm_up_s", "warm_up_plans")}
    summary["targets"] = against(summary, dimension)
    axes = frozenset(scenario.tasks.space.ranged)
    return document("online", scenario.name, [_short(row, axes) for row in rows], _rounded(summary), NOTES)


def judge(
    planned: Sequence[Row],
    references: Sequence[Row],
    paper: Sequence[Mapping[str, Row]],
    symmetries: Sequence[Symmetry] | None = None,
) -> list[Row]:
    """The rows of plan, the first ones with `reference` and `paper`; see NOTES for what is in them.

    `symmetries` are those of each row's task, by default none.
    """
    rows = [dict(row) for row in planned]
    for row, reference, symmetry in zip(rows, references, symmetries or [NO_SYMMETRY] * len(rows), strict=False):
        row["reference"] = _compared(row, reference, symmetry)
    for row, calls in zip(rows, paper, strict=False):
        best = row["reference"]["cost"]
        row["paper"] = {method: call | {"optimal": reaches(call["cost"], best)} for method, call in calls.items()}
    return rows


def _compared(row: Row, reference: Row, symmetry: Symmetry) -> Row:
    best, solved = reference["cost"], row["path"] != "failed"
    within = solved and reaches(row["cost"], best)
    same_gait = solved and best is not None and _gait(row["pattern"], symmetry) == _gait(reference["pattern"], symmetry)
    excess = None if best is None or not solved else row["cost"] / best - 1
    return {
        "gait": reference["gait"],
        "cost": best,
        "excess": excess,
        "consistent": within or same_gait,
        "within": within,
        "better": excess is not None and excess < -SAME_OPTIMUM,
        "picked_best": row["picked"] == reference["gait"],
        "probability": row["probability"],
    }


def _gait(pattern: str, symmetry: Symmetry) -> Pattern:
    return gait_of(Pattern.from_text(pattern), symmetry)


def summarise(rows: Sequence[Row], select_us: Sequence[float]) -> Row:
    """All numbers but the targets; rates are shares of the tasks, None without a task to tell from."""
    compared = [row["reference"] for row in rows if row.get("reference", {}).get("cost") is not None]
    return {
        "tasks": len(rows),
        "feasible_rate": _share([row["feasible"] for row in rows]),
        "fast_rate": _share([row["path"] == "fast" for row in rows]),
        "paths": dict(Counter(row["path"] for row in rows).most_common()),
        **_agreement(compared),
        **_quantiles("plan_ms", [row["wall_ms"] for row in rows]),
        **_quantiles("plan_cpu_ms", [row["cpu_ms"] for row in rows]),
        "wall_over_cpu": sum(row["wall_ms"] for row in rows) / sum(row["cpu_ms"] for row in rows),
        **{f"{part}_ms_p50": statistics.median(row[f"{part}_ms"] for row in rows) for part in PARTS},
        **_quantiles("iterations", [row["iterations"] for row in rows]),
        **_quantiles("select_us", select_us),
        "first_as_select_rate": _share([row["first"] == row["picked"] for row in rows]),
        "same_as_select_rate": _share([row["gait"] == row["picked"] for row in rows]),
        **_against_paper([row["paper"] for row in rows if "paper" in row]),
    }


def _agreement(compared: Sequence[Row]) -> Row:
    """How plan, and select, fare beside the references that found a motion."""

    def worst(consistent: bool) -> float | None:
        known = (each["excess"] for each in compared if each["consistent"] is consistent)
        return max((excess for excess in known if excess is not None), default=None)

    return {
        "consistent_tasks": len(compared),
        "consistent_rate": _share([each["consistent"] for each in compared]),
        "within_rate": _share([each["within"] for each in compared]),
        "better_rate": _share([each["better"] for each in compared]),
        "excess_worst_consistent": worst(True),
        "excess_worst_inconsistent": worst(False),
        "picked_best_rate": _share([each["picked_best"] for each in compared]),
        "calibration_error": calibration_error(
            [each["probability"] for each in compared], [each["picked_best"] for each in compared]
        ),
    }


def calibration_error(probabilities: Sequence[float], right: Sequence[bool]) -> float | None:
    """The expected calibration error: |share right - mean probability| by bin, weighted by tasks; None without any."""
    if not probabilities:
        return None
    p, hit = np.array(probabilities), np.array(right, dtype=float)
    bins = np.minimum((p * BINS).astype(int), BINS - 1)
    return float(sum(abs((hit - p)[bins == each].sum()) for each in np.unique(bins)) / len(p))


def _against_paper(calls: Sequence[Mapping[str, Row]]) -> Row:
    if not calls:
        return {"speedup_vs_paper_median": None}
    methods = {}
    for method in METHODS:
        cpu, wall = ([each[method][clock] for each in calls] for clock in ("cpu_s", "wall_s"))
        methods[method] = {
            "runs": len(calls),
            "successful": sum(each[method]["status"] == "solved" for each in calls),
            "optimal": sum(each[method]["optimal"] for each in calls),
            "time_median_s": statistics.median(cpu),
            "time_mean_s": statistics.fmean(cpu),
            "wall_median_s": statistics.median(wall),
        }
    speedups = {method: _speedup(calls, method) for method in METHODS if method != PLAN}
    return {"speedup_vs_paper_median": speedups[PAPER]["median"], "speedup": speedups, "methods": methods}


def _speedup(calls: Sequence[Mapping[str, Row]], method: str) -> dict[str, float]:
    found = {}
    for prefix, clock in (("", "cpu_s"), ("wall_", "wall_s")):
        theirs, plans = ([each[name][clock] for each in calls] for name in (method, PLAN))
        found[f"{prefix}median"] = statistics.median(a / b for a, b in zip(theirs, plans, strict=True))
        found[f"{prefix}of_medians"] = statistics.median(theirs) / statistics.median(plans)
    return found


def _quantiles(name: str, values: Sequence[float]) -> dict[str, float]:
    return {
        **{f"{name}_p{q}": float(np.percentile(values, q)) for q in (50, 95, 99)},
        f"{name}_max": float(max(values)),
    }


def _share(flags: Sequence[bool]) -> float | None:
    return sum(flags) / len(flags) if flags else None


def _short(row: Row, axes: Collection[str]) -> Row:
    """The row rounded, but for its task, and without what it says twice."""
    agreed = {"picked"} if row["picked"] == row["gait"] else set()
    shown = {key: value for key, value in row.items() if key not in {"probability", "feasible", "first"} | agreed}
    return shown | {key: _rounded(value) for key, value in shown.items() if key not in axes}


def _rounded(value: Any) -> Any:
    match value:
        case Mapping():
            return {key: _rounded(inner) for key, inner in value.items()}
        case float():
            return float(f"{value:.{DIGITS}g}")
    return value
