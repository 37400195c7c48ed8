"""How fast a planner gets an answer: loading a map in a fresh process, and `select` by the call."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.document import document
from gaitflow.runtime import GaitMap

HEAVY = ("torch", "dask", "casadi", "pandas", "sklearn", "pydantic", "pyarrow", "scipy")
STARTS = 7
FRESH = """
import json, sys, time
task = json.loads(sys.argv[2])
start = time.perf_counter()
from gaitflow.runtime import GaitMap
gait_map = GaitMap.load(sys.argv[1])
gait_map.select(**task)
seconds = time.perf_counter() - start
print(json.dumps({"seconds": seconds, "modules": sorted({name.partition(".")[0] for name in sys.modules})}))
"""


def run(artifact: Path, calls: int = 20_000, seed: int = 0) -> dict[str, Any]:
    """The document: a row a fresh process; `calls` random in-domain tasks, one by one and as one batch."""
    gait_map = GaitMap.load(artifact)
    domain, rng = gait_map.manifest.domain, np.random.default_rng(seed)
    columns = {axis: rng.uniform(values[0], values[-1], calls) for axis, values in domain.axes.items()}
    tasks: list[dict[str, Any]] = [
        dict(zip(columns, row, strict=True)) for row in np.column_stack(list(columns.values())).tolist()
    ]
    rows = [_fresh([str(artifact), json.dumps(domain.middle)]) for _ in range(STARTS)]
    for task in tasks[:200]:
        gait_map.select(**task)
    times = np.empty(calls)
    for index, task in enumerate(tasks):
        start = time.perf_counter()
        gait_map.select(**task)
        times[index] = time.perf_counter() - start
    start = time.perf_counter()
    gait_map.select_many(**columns)
    batch = time.perf_counter() - start
    p50, p95, p99 = (float(x) * 1e6 for x in np.percentile(times, (50, 95, 99)))
    summary = {
        "load_and_first_select_s_median": statistics.median(row["seconds"] for row in rows),
        "load_and_first_select_s_max": max(row["seconds"] for row in rows),
        "heavy_modules_loaded": sorted({name for row in rows for name in row["heavy"]}),
        "select_us_p50": p50,
        "select_us_p95": p95,
        "select_us_p99": p99,
        "select_us_max": float(times.max()) * 1e6,
        "batch_us_per_task": batch / calls * 1e6,
        "classifier": gait_map.manifest.classifier_kind,
        "calls": calls,
    }
    notes = ("load_and_first_select_s: a fresh Python that imports gaitflow.runtime, loads the map and selects once",)
    return document("select", gait_map.manifest.name, rows, summary, notes)


def _fresh(arguments: list[str]) -> dict[str, Any]:
    done = subprocess.run([sys.executable, "-c", FRESH, *arguments], capture_output=True, text=True, check=True)
    answer = json.loads(done.stdout)
    return {"seconds": answer["seconds"], "heavy": sorted(set(HEAVY) & set(answer["modules"]))}
