"""The artifact's problem, loaded once and shared by all threads; IPOPT for it, where the fast method does not converge.

The problem is a serialised CasADi function, and reading one is C++ code that trusts its input: an artifact should come
from a source you trust. Its digest and size are checked first, and nothing but planning opens that file.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow.core.errors import ArtifactError
from gaitflow.core.trajectory import Array
from gaitflow.runtime.files import PROBLEM, read_checked
from gaitflow.runtime.manifest import Manifest
from gaitflow.solvers.options import IPOPT_WARM
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import derivatives

# IPOPT with MUMPS crashes when two threads of one process solve at once (casadi issue 3456).
_SOLVING = threading.Lock()


@dataclass(frozen=True)
class IpoptAnswer:
    """Where IPOPT ended, w [nw], and what it said; a solve that threw leaves its start, with 0 iterations."""

    w: Array
    iterations: int
    status: str


class Problem:
    """The problem of the artifact in `folder`. Raises ImportError without CasADi, ArtifactError as `load_problem`."""

    def __init__(self, folder: Path, manifest: Manifest) -> None:
        self._manifest = manifest
        self.function = load_problem(folder, manifest)
        self.derivatives = derivatives(self.function)

    def ipopt(self, space: GaitSpace, task: Array, primal: Array, bounds: Array, rows: Array) -> IpoptAnswer:
        """Solve a gait at task (v, T) from a decision vector [nw] and multipliers of bounds [nw] and rows [ng].

        One call at a time in the whole process.
        """
        with _SOLVING:
            solver = self._ipopt
            try:
                answer = solver(
                    x0=primal, p=task, lbx=space.lower, ubx=space.upper, lbg=space.lower_rows, ubg=space.upper_rows,
                    lam_x0=bounds, lam_g0=rows,
                )  # fmt: skip
                statistics = solver.stats()
            except RuntimeError as error:
                return IpoptAnswer(primal, 0, f"the solver failed: {str(error).strip().splitlines()[-1][:200]}")
        w = np.asarray(answer["x"], dtype=float).ravel()
        return IpoptAnswer(w, int(statistics.get("iter_count", 0)), str(statistics["return_status"]))

    def cost(self, w: Array, task: Array) -> float:
        """The problem's cost of w [nw] at task (v, T)."""
        return float(self.function(w, task)[0])

    @cached_property
    def _ipopt(self) -> Any:
        import casadi

        w, task = casadi.SX.sym("w", self._manifest.layout.variables), casadi.SX.sym("task", 2)
        cost, rows = self.function(w, task)
        program = {"x": w, "p": task, "f": cost, "g": rows}
        return casadi.nlpsol("refine", "ipopt", program, _options(self._manifest.solver_options))


def load_problem(folder: Path, manifest: Manifest) -> Any:
    """The function (w [nw], task [2]) -> (cost [1], rows [ng]) of an artifact. Raises ArtifactError."""
    casadi, path = _casadi(), folder / PROBLEM
    content = read_checked(folder, PROBLEM, manifest.files[PROBLEM])
    try:
        function = casadi.Function.deserialize(content.decode("ascii"))
    except (RuntimeError, ValueError) as error:
        reason = str(error).strip().splitlines()[-1][:200]
        raise ArtifactError(
            f"{path}: CasADi {casadi.__version__} cannot read it ({reason}); install the version that made it, "
            "which `code` in manifest.json names"
        ) from None
    takes = [function.size_in(i) for i in range(function.n_in())]
    gives = [function.size_out(i) for i in range(function.n_out())]
    if takes != [(manifest.layout.variables, 1), (2, 1)] or gives != [(1, 1), (manifest.layout.rows, 1)]:
        raise ArtifactError(
            f"{path}: the problem maps {takes} to {gives}; expected w [{manifest.layout.variables}] and task [2] "
            f"to cost [1] and rows [{manifest.layout.rows}]"
        )
    return function


def _options(options: Mapping[str, float | int | str]) -> dict[str, Any]:
    ipopt = {**IPOPT_WARM, **options, "linear_solver": "mumps", "print_level": 0, "sb": "yes"}
    return {"ipopt": ipopt, "print_time": False, "error_on_fail": False, "show_eval_warnings": False}


def _casadi() -> Any:
    try:
        import casadi
        import qdldl  # noqa: F401
        import scipy.sparse  # noqa: F401
    except ImportError as missing:
        raise ImportError(f'refining a plan needs {missing.name}: pip install "gaitflow[solve]"') from None
    return casadi
