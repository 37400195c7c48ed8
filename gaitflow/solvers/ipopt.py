"""IPOPT, the interior-point method with a line search: the fallback and the referee of our own."""

from __future__ import annotations

from typing import Any

import casadi as ca

from gaitflow.core.trajectory import Array
from gaitflow.solvers.options import Options


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
