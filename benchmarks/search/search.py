"""One task searched by a scenario's strategy, measured; made to be called in a child process."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from benchmarks.child import Child, Lost
from benchmarks.search.tasks import task_of
from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, representative
from gaitflow.core.names import gait_name
from gaitflow.search import Solution, solve_tasks

LOST = "lost"  # status of a search whose process crashed or hung
BONMIN_LIMIT_S = 300.0  # of one Bonmin run in the plane: several times what it usually takes
OURS = ("guided", "patterns")  # strategies that are not the paper's


class Search:
    """Searches a task anew at every call: nothing is known from a neighbour or an earlier call."""

    def __init__(self, scenario: Mapping[str, Any]) -> None:
        self._scenario = Scenario.from_data(scenario, "the bench's scenario")

    def __call__(self, task: Mapping[str, float], seed: int | None) -> dict[str, Any]:
        """The best motion found at a task, as `summarise` puts it, and the CPU and wall time of the whole."""
        wall, cpu = time.perf_counter(), time.process_time()
        found = solve_tasks(self._scenario, [task_of(self._scenario, task)], None if seed is None else [seed])
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        return summarise(self._scenario, found) | {"whole_cpu_s": cpu, "whole_wall_s": wall}


def bonmin(scenario: Scenario, limit_s: float | None = None) -> Scenario:
    """The scenario searched by Bonmin for `limit_s` of CPU time, by default BONMIN_LIMIT_S."""
    return _searched(scenario, name="bonmin", pattern=None, solve_time_limit=limit_s or BONMIN_LIMIT_S)


def patterns(scenario: Scenario) -> Scenario:
    """The scenario searched by trying its patterns, with its own restarts, seed and limit."""
    return _searched(scenario, name="patterns", pattern=None)


def ours(scenario: Scenario) -> Scenario:
    """The scenario searched by its own strategy, or by `patterns` where that is the paper's or a single gait."""
    return scenario if scenario.strategy.name in OURS else patterns(scenario)


def _searched(scenario: Scenario, **changes: Any) -> Scenario:
    return scenario.model_copy(update={"strategy": scenario.strategy.model_copy(update=changes)})


def search(child: Child, task: Mapping[str, float], seed: int | None, limit_s: float) -> dict[str, Any]:
    """One call of a child's `Search` at a task's values by axis; one that is lost makes a row with the status LOST."""
    try:
        return dict(child.call(limit_s, task=task, seed=seed))
    except Lost as lost:
        return {
            "status": LOST, "solver_status": str(lost), "gait": None, "pattern": None, "cost": None, "violation": None,
            "cpu_s": lost.cpu_s, "wall_s": lost.wall_s, "solves": None, "counts": {}, "costs": {},
            "whole_cpu_s": lost.cpu_s, "whole_wall_s": lost.wall_s,
        }  # fmt: skip


def summarise(scenario: Scenario, found: Sequence[Solution]) -> dict[str, Any]:
    """The cheapest of a task's solutions, and how all of them went.

    gait (name), pattern, cost, violation; cpu_s, wall_s of all solver calls; counts of solutions by status; costs of
    each solved pattern, its cycle cut as in `gaits.representative`. Without a solved one the gait and cost are None
    and status and solver_status tell of the only row, or "infeasible" when a whole search found nothing.
    """
    solved = sorted((row for row in found if row.status == "solved"), key=lambda row: (row.cost, row.pattern))
    best = solved[0] if solved else None
    told = best or (found[0] if len(found) == 1 else None)
    costs = {
        representative(Pattern.from_text(row.pattern), scenario.symmetry(row.task)).text: row.cost
        for row in reversed(solved)
    }
    return {
        "status": told.status if told else "infeasible",
        "solver_status": told.solver_status if told else "no pattern has a feasible motion",
        "gait": gait_name(Pattern.from_text(best.gait), scenario.robot.leg_names) if best else None,
        "pattern": best.pattern if best else None,
        "cost": best.cost if best else None,
        "violation": best.violation if best else None,
        "cpu_s": math.fsum(row.cpu_s for row in found),
        "wall_s": math.fsum(row.wall_s for row in found),
        "solves": sum(row.solves for row in found),
        "counts": dict(sorted(Counter(row.status for row in found).items())),
        "costs": costs,
    }
