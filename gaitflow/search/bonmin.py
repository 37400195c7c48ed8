"""The paper's way, section III.B and III.C: the MINLP in big-M form, restarted from random seeds.

Bonmin explores the contact variables by branch and bound on local NLP solutions; on this nonconvex problem that is a
heuristic, hence the restarts. A found pattern is then solved once more in bounds form from Bonmin's point,
so that the stored motion obeys its contacts exactly and not to Bonmin's tolerances.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from gaitflow.config.scenario import Scenario
from gaitflow.core.gaits import Pattern, representative
from gaitflow.core.task import Task
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.search.attempts import best_of, seed_of, solution
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import FixedGaitSolver, Start
from gaitflow.solvers.ipopt import call_solver, symbolic

NO_PATTERN = "none"
NODE_ITERATIONS = 150  # of IPOPT in one node; a node that needs more is as good as infeasible


def solve_restarts(scenario: Scenario, tasks: Sequence[Task], seeds: Sequence[int]) -> list[Solution]:
    """One row per task and seed: the pattern that Bonmin ends with, or a row without one and why."""
    problem = transcribe(scenario)
    bonmin = make_bonmin(problem, scenario.strategy.solve_time_limit)
    fixed = FixedGaitSolver(problem, scenario.strategy.solve_time_limit)
    return [_restart(problem, bonmin, fixed, task, seed) for task in tasks for seed in seeds]


def make_bonmin(problem: GaitProblem, time_limit: float) -> ca.Function:
    """Bonmin's branch and bound on the big-M form; `time_limit` in seconds per run."""
    contacts = problem.layout.legs * problem.layout.phases
    options: dict[str, Any] = {
        "print_time": False,
        "discrete": [False] * problem.layout.nw + [True] * contacts,
        "bonmin": {
            "algorithm": "B-BB",
            # By default one node whose program fails ends the whole run with an exception.
            "nlp_failure_behavior": "fathom",
            "max_iter": NODE_ITERATIONS,
            "time_limit": time_limit,
            "bb_log_level": 0,
            "nlp_log_level": 0,
            "lp_log_level": 0,
            "print_level": 0,
            "sb": "yes",
        },
    }
    return ca.nlpsol("minlp", "bonmin", symbolic(problem.minlp), options)


def _restart(problem: GaitProblem, bonmin: ca.Function, fixed: FixedGaitSolver, task: Task, seed: int) -> Solution:
    scenario, layout = problem.scenario, problem.layout
    speed, cycle = task.speed, task.cycle_duration
    rng = np.random.default_rng(seed_of(seed, speed, cycle))
    start = np.concatenate(
        [starts.random(scenario.robot, layout, speed, cycle, rng), rng.integers(0, 2, layout.legs * layout.phases)]
    )
    bounds = problem.minlp_bounds()
    wall, cpu = time.perf_counter(), time.process_time()
    status, iterations, result = call_solver(
        bonmin,
        {
            "x0": start,
            "p": [speed, cycle],
            "lbx": bounds.lower,
            "ubx": bounds.upper,
            "lbg": bounds.lower_rows,
            "ubg": bounds.upper_rows,
        },
    )
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    nan = float("nan")
    row = Solution(
        speed, cycle, task.split, NO_PATTERN, NO_PATTERN, scenario.strategy.name, f"random-{seed}", seed,
        "infeasible" if status == "INFEASIBLE" else "failed", status, nan, nan, iterations, 1, wall, cpu,
    )  # fmt: skip
    contacts = result["x"][layout.nw :].reshape(layout.legs, layout.phases)
    # Stopped before it met a solution, Bonmin hands back zeros; and where no leg ever stands there is no gait.
    decided = np.abs(contacts - contacts.round()).max() < 1e-3 and contacts.round().any()
    decided = decided and not status.startswith("exception")
    if status == "INFEASIBLE" or not decided:
        return row
    found = Pattern(tuple("".join(str(int(c)) for c in leg.round()) for leg in contacts))
    # Bonmin's point belongs to its own cut of the cycle, so it is polished before the cycle is rotated.
    polished = fixed.solve(found, speed, cycle, Start(row.start, result["x"][: layout.nw]))
    canonical = representative(found, scenario.robot.mirror_permutation if scenario.robot.mirror else None)
    kept = solution(scenario, task, found, [polished])
    return replace(
        kept,
        seed=seed,
        solver_status=f"{status}, then {polished.solver_status}; cyclically {canonical.text}",
        status="solved" if best_of([polished]) else "failed",
        iterations=iterations + polished.iterations,
        solves=2,
        wall_s=wall + polished.wall_s,
        cpu_s=cpu + polished.cpu_s,
    )
