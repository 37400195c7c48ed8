"""How much work a scenario needs, before it is run: the number of solves, and their time, measured on a few."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gaitflow.config.scenario import Scenario
from gaitflow.config.tasks import tasks_of
from gaitflow.execute.expected_solves import ExpectedSolves
from gaitflow.store.units import plan_units

TRIED = 4  # gaits, one of which derives the problem and is not timed
GUIDED_SHARE = 0.5  # of that time: most solves of a guided search are on its coarse mesh


@dataclass(frozen=True)
class Forecast:
    """About how many solves all units take, and CPU hours on a core like this one; None for Bonmin's runs."""

    solves: int
    cpu_hours: float | None


def forecast(scenario: Scenario) -> Forecast:
    """Foretell a scenario's work from what its screen leaves, and from a few gaits solved at one of its tasks.

    An adaptive sampling is taken to search as many tasks as it may.
    """
    units = plan_units(scenario)
    expected = ExpectedSolves.of_plan(units)
    solves = round(sum(map(expected.of, units)))
    if scenario.tasks.adaptive is not None:
        solves = round(solves / len(units) * scenario.tasks.adaptive.most)
    if scenario.strategy.name == "bonmin":
        return Forecast(solves, None)
    share = GUIDED_SHARE if scenario.strategy.name == "guided" else 1.0
    return Forecast(solves, solves * share * _seconds_a_solve(scenario) / 3600)


def _seconds_a_solve(scenario: Scenario) -> float:
    """CPU time [s] of a solve from the nominal start, the mean of a few gaits of the library."""
    from gaitflow.problem import transcribe
    from gaitflow.search import starts
    from gaitflow.search.bound import ruled_out
    from gaitflow.search.exhaustive import candidate_patterns
    from gaitflow.search.moves import library
    from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start

    problem, tasks = transcribe(scenario), tasks_of(scenario)
    task = tasks[len(tasks) // 3]
    known = library(len(scenario.robot.legs), scenario.transcription.phases, scenario.symmetry(task))
    gaits = candidate_patterns(scenario, task) if scenario.strategy.pattern else known
    possible = [pattern for pattern in gaits if ruled_out(scenario, pattern, task, math.inf) is None] or list(gaits)
    chosen = possible[:: max(1, len(possible) // TRIED)][:TRIED]
    solver = FixedGaitSolver(problem, scenario.strategy.solve_time_limit)
    start = Start("nominal", starts.nominal(scenario.robot, problem.layout, task))
    times = [solver.solve(pattern, task, start, fallback=False).cpu_s for pattern in chosen]
    return sum(times[1:]) / len(times[1:]) if len(times) > 1 else times[0]
