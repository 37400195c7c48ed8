"""Solving tasks: one narrow interface over the fixed gait, Bonmin's restarts, exhaustive and guided search."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gaitflow.config.scenario import Scenario
from gaitflow.core.task import Task
from gaitflow.search.solution import Solution

if TYPE_CHECKING:
    from gaitflow.solvers.fixed_gait import NewSolver

__all__ = ["Solution", "solve_tasks"]


def solve_tasks(
    scenario: Scenario,
    tasks: Sequence[Task],
    seeds: Sequence[int] | None = None,
    new_solver: NewSolver | None = None,
) -> list[Solution]:
    """Solve tasks by the scenario's strategy; a pure function of its arguments.

    `patterns` and `fixed_gait` solve them as a chain of neighbours, a row per task and pattern; so does `guided`, with
    rows for the patterns that it met. `bonmin` runs once per task and seed, by default the seeds strategy.seed,
    seed + 1, ..., a row each. `new_solver` makes the solvers of fixed gaits (default: `FixedGaitSolver`); one that
    remembers may be put there, none that answers otherwise.
    """
    # Not before: reading a dataset imports this package and needs no CasADi.
    from gaitflow.solvers.fixed_gait import FixedGaitSolver

    make = new_solver or FixedGaitSolver
    if scenario.strategy.name == "bonmin":
        from gaitflow.search.bonmin import solve_restarts

        first = scenario.strategy.seed
        return solve_restarts(scenario, tasks, seeds or range(first, first + scenario.strategy.restarts), make)
    if scenario.strategy.name == "guided":
        from gaitflow.search.guided import solve_guided

        return solve_guided(scenario, tasks, make)
    from gaitflow.search.exhaustive import solve_chain

    return solve_chain(scenario, tasks, make)
