"""Exhaustive search, ours: solve every pattern of a task that cannot be ruled out, each from its neighbour.

Where the paper restarts a MINLP, we try all canonical patterns: in the plane 36 with one stance per leg, in space
2,628. A chain of neighbouring tasks is solved in order, so that a pattern starts, primal and dual, from its solution at
the task before. The best few gaits of a task are then solved again from other starts.

A search can be cut into parts, and an incumbent's cost, known from elsewhere, rules out what costs more for certain:
what then remains to be solved is a certificate that the incumbent is the best, or finds what is better.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, all_patterns
from gaitflow.core.task import Task
from gaitflow.problem import transcribe
from gaitflow.search.attempts import best_of, leaders, recheck, screened, solution, until_feasible
from gaitflow.search.bound import ruled_out
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import Attempt, FixedGaitSolver

RECHECKED_GAITS = 3


def candidate_patterns(scenario: Scenario) -> tuple[Pattern, ...]:
    """The patterns to try: the given one (fixed_gait), or this part of all representatives under the stance setting."""
    strategy, robot = scenario.strategy, scenario.robot
    if strategy.pattern is not None:
        return (Pattern.from_text(strategy.pattern),)
    mirror = robot.mirror_permutation if robot.mirror else None
    every = all_patterns(len(robot.legs), scenario.transcription.phases, scenario.stances_per_leg, mirror)
    part, parts = strategy.part or (0, 1)
    return every[part::parts]


def solve_chain(scenario: Scenario, tasks: Sequence[Task]) -> list[Solution]:
    """Solve a chain of neighbouring tasks; a row per task and pattern, in that order, screened ones included."""
    solver = FixedGaitSolver(transcribe(scenario), scenario.strategy.solve_time_limit)
    patterns = candidate_patterns(scenario)
    incumbent = math.inf if scenario.strategy.incumbent is None else scenario.strategy.incumbent
    rows: list[Solution] = []
    before: dict[Pattern, Attempt] = {}
    first = True
    for task in tasks:
        attempts: dict[Pattern, list[Attempt]] = {}
        reasons: dict[Pattern, str] = {}
        for pattern in patterns:
            reason = ruled_out(scenario, pattern, task.speed, task.cycle_duration, incumbent)
            if reason is not None:
                reasons[pattern] = reason
                continue
            # A pattern that just failed at the neighbour is not worth random starts here.
            restarts = scenario.strategy.restarts if first or pattern in before else 0
            attempts[pattern] = until_feasible(solver, pattern, task, before.get(pattern), restarts)
        for pattern in leaders(scenario, attempts, RECHECKED_GAITS):
            attempts[pattern] += recheck(solver, pattern, task, attempts[pattern])
        for pattern in patterns:
            if pattern in reasons:
                rows.append(screened(scenario, task, pattern, reasons[pattern]))
            else:
                rows.append(solution(scenario, task, pattern, attempts[pattern]))
        before = {pattern: best for pattern, tried in attempts.items() if (best := best_of(tried)) is not None}
        first = False
    return rows
