"""Plan random tasks of a map: python examples/random_tasks.py models/anymal-omni [COUNT] [BUILD].

BUILD is the folder of the map's compiled export, with which plans take a fraction of the time.
"""

import sys
from collections.abc import Iterator
from itertools import islice
from statistics import fmean, median
from typing import Any

import numpy as np

from gaitflow.runtime import GaitMap

SEED = 0


def random_tasks(gait_map: GaitMap) -> Iterator[dict[str, Any]]:
    """Tasks uniform in the map's domain, without end: their values by axis."""
    rng = np.random.default_rng(SEED)
    axes = gait_map.manifest.domain.axes
    while True:
        task: dict[str, Any] = {axis: float(rng.uniform(values[0], values[-1])) for axis, values in axes.items()}
        if gait_map.select(**task).in_domain:
            yield task


def main(folder: str, count: str = "1000", build: str | None = None) -> None:
    """Print how many plans have a motion, which path they took, and how long they took."""
    gait_map = GaitMap.load(folder, compiled=build)
    plans = []
    for task in islice(random_tasks(gait_map), int(count)):
        plans.append(gait_map.plan(**task))
        if len(plans) % 100 == 0:
            print(f"planned {len(plans)} of {count}", file=sys.stderr)

    def share(chosen: list[bool]) -> str:
        return f"{sum(chosen):5} of {len(plans)}, {np.mean(chosen):.1%}"

    print(f"{gait_map.manifest.name} {gait_map.manifest.version}, random tasks of its domain, seed {SEED}")
    print("feasible plans      ", share([plan.feasible for plan in plans]))
    print("first gait, Newton  ", share([plan.path == "fast" for plan in plans]))
    print("another gait        ", share([plan.path.startswith(("next", "cheaper")) for plan in plans]))
    print("by IPOPT            ", share([plan.path == "fallback" for plan in plans]))
    print(f"gaits tried, mean    {fmean(len(plan.tried) for plan in plans):.1f}")
    print(f"iterations, mean     {fmean(plan.iterations for plan in plans):.0f}")
    print(f"time, median         {median(plan.time_ms for plan in plans):.1f} ms")


if __name__ == "__main__":
    main(*sys.argv[1:])
