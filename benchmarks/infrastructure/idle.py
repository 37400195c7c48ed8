"""Solvers that solve nothing, in place of `gaitflow.search:solve_tasks`: only the work of moving units remains."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.search.solution import Solution

HEAVY = ("torch", "sklearn", "skorch", "matplotlib", "onnxruntime", "pandas", "snakemake", "casadi", "pyarrow", "dask")


def no_time(
    scenario: Scenario, tasks: Sequence[Task], seeds: tuple[int, ...] | None, new_solver: object
) -> list[Solution]:
    """Answer at once."""
    return idle_solutions(scenario, tasks)


def one_second(
    scenario: Scenario, tasks: Sequence[Task], seeds: tuple[int, ...] | None, new_solver: object
) -> list[Solution]:
    """Answer after one second."""
    time.sleep(1.0)
    return idle_solutions(scenario, tasks)


def idle_solutions(scenario: Scenario, tasks: Sequence[Task]) -> list[Solution]:
    """A row a task that says "infeasible"; its `solver_status` names the heavy modules that this process has loaded."""
    return [
        Solution(
            task=task,
            pattern="",
            gait="",
            strategy=scenario.strategy.name,
            start="",
            seed=0,
            status="infeasible",
            solver_status=",".join(loaded()),
        )
        for task in tasks
    ]


def loaded() -> list[str]:
    """Those of HEAVY that this process has imported."""
    return [name for name in HEAVY if name in sys.modules]
