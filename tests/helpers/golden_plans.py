"""What the published maps plan at a few random tasks of their domains, recorded.

Run as a script it records versions that are new; without the file, all of them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.runtime import GaitMap, Plan
from gaitflow.runtime.manifest import FORMAT
from gaitflow.runtime.manifest_file import read_manifest
from gaitflow.runtime.versions import resolve

MODELS = Path(__file__).parents[2] / "models"
GOLDEN = Path(__file__).parents[1] / "data" / "golden_plans.json"
EASY, HARD = 4, 4  # plans a map: the first ones drawn, and those of the most iterations
MOST = 250  # iterations: more take a test too long, or are IPOPT's
DRAWN, DRAWN_WIDE = 200, 24  # on up to three axes and on more, where a plan takes seconds
SPREAD = 1  # iterations by which another machine's rounding may differ
NUDGE = 1e-9  # of a task's values: more than another processor's rounding, less than a robot can tell
LOCAL = "quickstart"  # what `make run` publishes in a checkout, and git ignores


def published() -> dict[str, Path]:
    """The newest version of every map of today's format that is shipped, by the scenario's name."""
    folders = {path.name: resolve(path) for path in sorted(MODELS.iterdir()) if path.is_dir() and path.name != LOCAL}
    return {name: folder for name, folder in folders.items() if read_manifest(folder).format == FORMAT}


def golden() -> dict[str, Any]:
    """What was recorded: by scenario the version and its plans."""
    recorded: dict[str, Any] = json.loads(GOLDEN.read_text())
    return recorded


def drawn(gait_map: GaitMap, count: int, seed: int = 0) -> list[dict[str, float]]:
    """Random tasks inside a map's domain."""
    axes, rng, tasks = gait_map.manifest.domain.axes, np.random.default_rng(seed), []
    while len(tasks) < count:
        task = {axis: round(float(rng.uniform(values[0], values[-1])), 6) for axis, values in axes.items()}
        if gait_map.manifest.domain.contains(task):
            tasks.append(task)
    return tasks


def steady(gait_map: GaitMap, plans: Iterable[Plan], count: int) -> list[Plan]:
    """The first `count` plans that take the same iterations at tasks a NUDGE away.

    Where the matrix is nearly singular, rounding decides how many a plan takes, and so does the processor.
    """

    def is_steady(plan: Plan) -> bool:
        nudged = [{axis: value * (1 + by) for axis, value in plan.task.items()} for by in (-NUDGE, NUDGE)]
        return all(abs(gait_map.plan(**task).iterations - plan.iterations) <= SPREAD for task in nudged)

    return list(islice(filter(is_steady, plans), count))


def record(folder: Path) -> dict[str, Any]:
    """Plans of one map."""
    gait_map = GaitMap.load(folder)
    tasks = drawn(gait_map, DRAWN_WIDE if len(gait_map.axes) > 3 else DRAWN)
    plans = [gait_map.plan(**task) for task in tasks]
    easy = steady(gait_map, plans, EASY)
    taken = [plan.task for plan in easy]
    bearable = [plan for plan in plans if plan.iterations <= MOST and plan.task not in taken]
    hard = steady(gait_map, sorted(bearable, key=lambda plan: -plan.iterations), HARD)
    rows = [
        {
            "task": {axis: plan.task[axis] for axis in gait_map.axes},
            "gait": plan.gait,
            "path": plan.path,
            "cost": plan.cost,
            "iterations": plan.iterations,
        }
        for plan in [*easy, *reversed(hard)]
    ]
    return {"version": folder.name, "plans": rows}


if __name__ == "__main__":
    known = golden() if GOLDEN.exists() else {}
    kept = {name: one for name, one in known.items() if published().get(name, Path()).name == one["version"]}
    made = {name: kept.get(name) or record(folder) for name, folder in published().items()}
    GOLDEN.write_text(json.dumps(made, indent=1) + "\n")
