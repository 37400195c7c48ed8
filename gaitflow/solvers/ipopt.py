"""The fixed-gait program: one pattern, one task, one start, solved by IPOPT and judged by our own check."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from gaitflow.core.check import FEASIBLE, worst
from gaitflow.core.gaits import Pattern
from gaitflow.core.trajectory import Array, Trajectory
from gaitflow.problem import GaitProblem
from gaitflow.search.solution import Multipliers

Options = dict[str, float | int | str]

# MUMPS' ordering is pinned to AMD, so that iterates repeat from run to run. What converges does so in 20 to 60
# iterations; what has not after 110 is a restoration that creeps towards an infeasible point.
IPOPT: Options = {"mumps_pivot_order": 0, "tol": 1e-8, "constr_viol_tol": 1e-9, "max_iter": 110}
# IPOPT moves a start away from its bounds unless every one of these is small.
IPOPT_WARM: Options = IPOPT | {
    "warm_start_init_point": "yes",
    "mu_init": 1e-4,
    "warm_start_bound_push": 1e-8,
    "warm_start_bound_frac": 1e-8,
    "warm_start_slack_bound_push": 1e-8,
    "warm_start_slack_bound_frac": 1e-8,
    "warm_start_mult_bound_push": 1e-8,
}


@dataclass(frozen=True)
class Start:
    """Where to start: w [nw] and, when known, the multipliers of a solved neighbour."""

    name: str
    w: Array
    multipliers: Multipliers | None = None


@dataclass(frozen=True)
class Attempt:
    """One solver call; `feasible` is our check's verdict, `cost` is unscaled."""

    start: str
    feasible: bool
    gave_up: bool  # not feasible, and the solver found no infeasibility either: a limit, an exception, a false success
    solver_status: str
    cost: float
    violation: float
    iterations: int
    wall_s: float
    cpu_s: float
    w: Array
    trajectory: Trajectory
    multipliers: Multipliers


class FixedGaitSolver:
    """Solves a scenario's program for any pattern and task; build once, call often, one per process."""

    def __init__(self, problem: GaitProblem, time_limit: float):
        """`time_limit` is the CPU time of one call [s]."""
        self.problem = problem
        self._scenario = problem.scenario.as_data()
        self._limit = time_limit

    @cached_property
    def _cold(self) -> ca.Function:
        return make_ipopt(self.problem.nlp, IPOPT | {"max_cpu_time": self._limit})

    @cached_property
    def _warm(self) -> ca.Function:
        return make_ipopt(self.problem.nlp, IPOPT_WARM | {"max_cpu_time": self._limit})

    def solve(self, pattern: Pattern, speed: float, cycle_duration: float, start: Start) -> Attempt:
        """One call from one start; speed v [m/s], cycle_duration T [s]. A solver's exception is a failed attempt."""
        solver = self._cold if start.multipliers is None else self._warm
        bounds = self.problem.bounds(pattern)
        arguments: dict[str, Any] = {
            "x0": start.w,
            "p": [speed, cycle_duration],
            "lbx": bounds.lower,
            "ubx": bounds.upper,
            "lbg": bounds.lower_rows,
            "ubg": bounds.upper_rows,
        }
        if start.multipliers is not None:
            arguments |= {"lam_x0": start.multipliers.bounds, "lam_g0": start.multipliers.rows}
        wall, cpu = time.perf_counter(), time.process_time()
        status, iterations, result = call_solver(solver, arguments)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        w = result["x"]
        trajectory = self.problem.layout.unpack(w, cycle_duration)
        violation = worst(self._scenario, trajectory, speed, cycle_duration, pattern.text)
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
        )


# A feasible point that is not a minimum would be a wrong cost: both the status and our check must agree.
CONVERGED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


def make_ipopt(program: ca.Function, options: Options) -> ca.Function:
    """A silent IPOPT, with MUMPS, of a program (w, task) -> (cost, rows)."""
    quiet: Options = {"linear_solver": "mumps", "print_level": 0, "sb": "yes"}
    return ca.nlpsol("gait", "ipopt", symbolic(program), {"print_time": False, "ipopt": quiet | options})


def symbolic(program: ca.Function) -> dict[str, ca.SX]:
    """The program as expressions, the form that `nlpsol` takes."""
    w, task = ca.SX.sym("w", program.numel_in(0)), ca.SX.sym("task", program.numel_in(1))
    cost, rows = program(w, task)
    return {"x": w, "p": task, "f": cost, "g": rows}


def call_solver(solver: ca.Function, arguments: dict[str, Any]) -> tuple[str, int, dict[str, Array]]:
    """Status, iterations and results as arrays; an exception becomes a status and the start is handed back."""
    try:
        result = solver(**arguments)
        stats = solver.stats()
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1][:200]
        rows = solver.numel_in("lbg")
        start = ca.DM(arguments["x0"])
        blank = {"x": start, "f": ca.DM(float("nan")), "lam_x": 0 * start, "lam_g": ca.DM.zeros(rows)}
        return f"exception: {reason}", 0, {key: value.full().ravel() for key, value in blank.items()}
    return (
        str(stats["return_status"]),
        int(stats.get("iter_count", 0)),
        {key: result[key].full().ravel() for key in ("x", "f", "lam_x", "lam_g")},
    )
