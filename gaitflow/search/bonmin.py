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
from gaitflow.core.trajectory import Array
from gaitflow.problem import GaitProblem, transcribe
from gaitflow.search import starts
from gaitflow.search.rows import solution
from gaitflow.search.solution import Solution
from gaitflow.solvers.fixed_gait import FixedGaitSolver, NewSolver, Start
from gaitflow.solvers.ipopt import call_solver, symbolic

NO_PATTERN = "none"
INTEGRAL = 1e-3  # largest distance of a contact that counts as decided from 0 or 1
NODE_ITERATIONS = 150  # of IPOPT in one node; a node that needs more is as good as infeasible


def solve_restarts(
    scenario: Scenario, tasks: Sequence[Task], seeds: Sequence[int], new_solver: NewSolver = FixedGaitSolver
) -> list[Solution]:
    """One row per task and seed: the pattern that Bonmin ends with, or a row without one and why."""
    problem = transcribe(scenario)
    bonmin = make_bonmin(problem, scenario.strategy.solve_time_limit)
    fixed = new_solver(problem, scenario.strategy.solve_time_limit)
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
    rng = np.random.default_rng(starts.seed_of(seed, *task.values))
    motion = starts.random(scenario.robot, layout, task, rng)
    bounds = problem.minlp_bounds()
    wall, cpu = time.perf_counter(), time.process_time()
    status, iterations, result = call_solver(
        bonmin,
        {
            "x0": np.concatenate([motion, rng.integers(0, 2, layout.legs * layout.phases)]),
            "p": task.parameters,
            "lbx": bounds.lower,
            "ubx": bounds.upper,
            "lbg": bounds.lower_rows,
            "ubg": bounds.upper_rows,
        },
    )
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    name = f"random-{seed}"
    contacts = result["x"][layout.nw :].reshape(layout.legs, layout.phases)
    if status == "INFEASIBLE" or status.startswith("exception") or not _is_pattern(contacts):
        return Solution(
            task=task,
            pattern=NO_PATTERN,
            gait=NO_PATTERN,
            strategy=scenario.strategy.name,
            start=name,
            seed=seed,
            status="infeasible" if status == "INFEASIBLE" else "failed",
            solver_status=status,
            iterations=iterations,
            solves=1,
            wall_s=wall,
            cpu_s=cpu,
        )
    found = Pattern(tuple("".join(str(int(c)) for c in leg.round()) for leg in contacts))
    # Bonmin's point belongs to its own cut of the cycle, so it is polished before the cycle is rotated.
    polished = fixed.solve(found, task, Start(name, result["x"][: layout.nw]))
    canonical = representative(found, scenario.symmetry(task))
    return replace(
        solution(scenario, task, found, [polished]),
        seed=seed,
        solver_status=f"{status}, then {polished.solver_status}; cyclically {canonical.text}",
        status="solved" if polished.feasible else "failed",
        iterations=iterations + polished.iterations,
        solves=2,
        wall_s=wall + polished.wall_s,
        cpu_s=cpu + polished.cpu_s,
    )


def _is_pattern(contacts: Array) -> bool:
    """Whether contacts [legs, phases] are decided, and not the zeros of a run that was stopped before it met any."""
    rounded = contacts.round()
    return bool(np.abs(contacts - rounded).max() < INTEGRAL and rounded.any())
