"""How much faster a plan is than one IPOPT solve, on every published map, in Python and in C++."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import child
from benchmarks.document import document
from benchmarks.online import cpp, mean_start, plan_times
from benchmarks.online.cpp import built, built_library
from benchmarks.paper.fixed_gait import scenario_of
from benchmarks.paper.table import off_grid_places
from benchmarks.rows import Row, RowStore
from gaitflow.certificate.judge import DEARER
from gaitflow.files import sha256_file
from gaitflow.runtime import GaitMap, atlas, attempt, compiled, gait_map, plan, problem, refine, rivals
from gaitflow.runtime.files import MANIFEST
from gaitflow.runtime.versions import resolve
from gaitflow.solvers import interior_point, kkt, point, program

TASKS, BY_IPOPT = 200, 60
TASK_LIMIT_S = 60.0  # wall time of a plan and a solve, beyond which the process counts as hung
AIMED_AT = {"python": 10.0, "compiled": 10.0, "cpp": 30.0}  # times one IPOPT solve, at the median
ALONE = ("alone", "compiled_alone")  # plans that try no other gait, in Python
_RUNTIME = (atlas, attempt, compiled, gait_map, plan, problem, refine, rivals)
_MODULES = (mean_start, plan_times, cpp, *_RUNTIME, interior_point, kkt, point, program)
NOTES = (
    f"A row a map, its newest version. {TASKS} tasks are random by `seed`, uniform in its domain, off its grid. Each "
    "is planned by GaitMap.plan in a process of one thread, there also by that of a map loaded with its `compiled` "
    "export, and by the exported C++ planner in another process. The export is built with -march=native. The first "
    f"{BY_IPOPT} are solved by IPOPT, too, from the mean motion of the picked gait's region, in the first process. At "
    "each task all of them take turns. All times are CPU times of a call [ms]; the plan's have choosing and checking "
    "in them.",
    "python, compiled, cpp: IPOPT's time over the planner's. median: of that ratio over the tasks. p99: IPOPT's median "
    "over the 99th percentile of the planner. Solves that failed count with the time they took: ipopt_failed. slow, "
    "compiled_slow: plans that did not take the fast path. cpp_not_refined: plans that C++ could not refine, as it has "
    "no IPOPT to fall back on.",
    "alone, compiled_alone: plans of the gait that the map picks before anything is solved, as `plan(gait=...)`; no "
    f"other gait is tried. alone_dearer: those that cost over {DEARER:.0%} more than the whole plan or have no motion.",
    "aimed at: a median of 10 in Python, compiled or not, of 30 in C++.",
)


def run(models: Path, tasks: int = TASKS, seed: int = 0, runs: Path = Path("runs")) -> Row:
    """The document, a row for the newest version of each map in `models`; a map measured before is left out.

    Raises ValueError where there is no map, child.Lost when a plan hangs, RuntimeError when the C++ does not build.
    """
    artifacts = [resolve(folder) for folder in sorted(models.iterdir()) if folder.is_dir()] if models.is_dir() else []
    if not artifacts:
        raise ValueError(f"{models}: holds no map; publish one first")
    rows = [_measured(artifact, tasks, seed, runs) for artifact in artifacts]
    return document("speed", None, rows, summarise(rows), NOTES)


def summarise(rows: Sequence[Row]) -> Row:
    """The ratios of each map, and how many maps have the medians that were aimed at."""
    reached = {way: sum(row[way]["median"] >= least for row in rows) for way, least in AIMED_AT.items()}
    ratios = {row["map"]: {way: row[way] for way in (*AIMED_AT, *ALONE)} for row in rows}
    return {"maps": len(rows), "reached": reached, **ratios}


def _measured(artifact: Path, tasks: int, seed: int, runs: Path) -> Row:
    about = {"manifest": sha256_file(artifact / MANIFEST)}
    key = {"map": f"{artifact.parent.name} {artifact.name}", "tasks": tasks, "seed": seed}
    store = RowStore("speed", scenario_of(artifact), runs, _MODULES, about)
    return store.rows([key], lambda _: _row(artifact, tasks, seed))[0]


def _row(artifact: Path, tasks: int, seed: int) -> Row:
    loaded = GaitMap.load(artifact)
    places = off_grid_places(loaded.manifest.domain, tasks, seed)
    with tempfile.TemporaryDirectory() as scratch:
        planner, _ = built(artifact, Path(scratch))
        export = planner.parents[1] / "map"
        library = built_library(export, Path(scratch) / "library")
        command = [str(planner), str(export / "map.bin")]
        about = {"artifact": str(artifact), "compiled": str(library), "planner": command}
        with child.Child("benchmarks.online.mean_start:PlanAndMeanStart", about) as process:
            timed: list[Row] = process.call(TASK_LIMIT_S * tasks, tasks=list(places), by_ipopt=BY_IPOPT)
    return compared(timed)


def compared(timed: Sequence[Row]) -> Row:
    """The row of a map, from its tasks' rows of `PlanAndMeanStart`."""
    ipopt = np.array([row["ipopt_ms"] for row in timed if "ipopt_ms" in row])
    times = {
        "python": [row["plan_ms"] for row in timed],
        "compiled": [row["compiled_ms"] for row in timed],
        "alone": [row["alone_ms"] for row in timed],
        "compiled_alone": [row["compiled_alone_ms"] for row in timed],
        "cpp": [row["cpp_ms"] for row in timed],
    }
    return {
        "ipopt_ms": _quantiles(ipopt),
        "ipopt": len(ipopt),
        "ipopt_failed": sum(not row.get("ipopt_solved", True) for row in timed),
        "slow": sum(row["plan_path"] != "fast" for row in timed),
        "compiled_slow": sum(row["compiled_path"] != "fast" for row in timed),
        "cpp_not_refined": sum(not row["cpp_refined"] for row in timed),
        "alone_dearer": sum(
            row["alone_path"] == "failed" or row["alone_cost"] > row["plan_cost"] * (1 + DEARER) for row in timed
        ),
        **{f"{way}_ms": _quantiles(ms) for way, ms in times.items()},
        **{
            way: {
                "median": float(np.median(ipopt / np.array(ms[: len(ipopt)]))),
                "p99": float(np.median(ipopt) / np.percentile(ms, 99)),
            }
            for way, ms in times.items()
        },
    }


def _quantiles(ms: Any) -> dict[str, float]:
    return {f"p{share}": float(np.percentile(ms, share)) for share in (50, 99)}
