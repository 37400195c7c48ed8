"""The paper's fixed-gait problem, section IV.B: the MINLP's big-M form with its contact variables fixed.

The baseline of Table I. It has the constraints that the pattern decides as rows, where ours has fixed variables.
"""

from __future__ import annotations

import time

import casadi as ca
import numpy as np

from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.task import Task
from gaitflow.problem import GaitProblem
from gaitflow.solvers.fixed_gait import Attempt, Start
from gaitflow.solvers.ipopt import call_solver, make_ipopt
from gaitflow.solvers.options import CONVERGED, IPOPT
from gaitflow.solvers.point import Multipliers

# IPOPT's own default. The bounds form makes do with less, but a baseline should not fail for want of iterations.
MAX_ITERATIONS = 3000


class BigMSolver:
    """Solves a scenario's big-M form for any pattern and task; build once, one per process."""

    def __init__(self, problem: GaitProblem, time_limit: float) -> None:
        """`time_limit` is the CPU time of one call [s]."""
        self.problem = problem
        self._scenario = problem.scenario.as_data()
        self._solver: ca.Function = make_ipopt(
            problem.minlp, IPOPT | {"max_iter": MAX_ITERATIONS, "max_cpu_time": time_limit}
        )

    def solve(self, pattern: Pattern, task: Task, start: Start) -> Attempt:
        """One call from the start's w [nw]. Multipliers are those of the big-M program.

        Judged as every solve is: forces in swing and slip in stance, here rows that hold to constr_viol_tol (1e-9), may
        not exceed the check's 1e-6 either. A run that stops at IPOPT's acceptable level can, and has failed then.
        Raises ValueError for a pattern with another shape than the scenario's.
        """
        layout = self.problem.layout
        if (pattern.legs, pattern.phases) != (layout.legs, layout.phases):
            raise ValueError(
                f"pattern {pattern.text} has {pattern.legs} legs and {pattern.phases} phases; "
                f"the scenario has {layout.legs} and {layout.phases}"
            )
        bounds = self.problem.minlp_bounds(pattern)
        arguments = {
            "x0": np.concatenate([start.w, bounds.lower[layout.nw :]]),
            "p": task.parameters,
            "lbx": bounds.lower,
            "ubx": bounds.upper,
            "lbg": bounds.lower_rows,
            "ubg": bounds.upper_rows,
        }
        wall, cpu = time.perf_counter(), time.process_time()
        status, iterations, result = call_solver(self._solver, arguments)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        w = result["x"][: layout.nw]
        trajectory = layout.unpack(w, task.cycle_duration)
        violation = worst(self._scenario, trajectory, task, pattern.text)
        feasible = violation <= FEASIBLE and status in CONVERGED
        return Attempt(
            start=start.name,
            feasible=feasible,
            gave_up=not feasible and status != "Infeasible_Problem_Detected",
            solver_status=status,
            cost=float(result["f"][0]) * self.problem.cost_scale,
            violation=violation,
            iterations=iterations,
            wall_s=wall,
            cpu_s=cpu,
            w=w,
            trajectory=trajectory,
            multipliers=Multipliers(result["lam_x"], result["lam_g"]),
            method="ipopt",
        )
