"""Refining a warm start into a plan: the fixed-gait problem of the artifact, solved by IPOPT.

The only module of the runtime that uses CasADi. The problem is a serialised CasADi function, and reading one is C++
code that trusts its input: an artifact should come from a source you trust. Its digest and size are checked first,
and nothing but `GaitMap.plan` opens that file.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gaitflow import check
from gaitflow.runtime.errors import ArtifactError
from gaitflow.runtime.files import PROBLEM, read_checked
from gaitflow.runtime.layout import unpack
from gaitflow.runtime.manifest import Manifest
from gaitflow.runtime.solver_options import WARM_START
from gaitflow.runtime.tensors import GaitTensors
from gaitflow.trajectory import Array, Trajectory

# IPOPT with MUMPS crashes when two threads of one process solve at once (casadi issue 3456).
_SOLVING = threading.Lock()

_CONVERGED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


@dataclass(frozen=True)
class Attempt:
    """One solve: what came out, our own verdict on it, and what the solver said.

    cost in the scenario's units; violation is the worst scaled one (gaitflow.check); a solve that threw leaves its
    start, with 0 iterations.
    """

    trajectory: Trajectory
    cost: float
    violation: float
    iterations: int
    solver_status: str

    @property
    def feasible(self) -> bool:
        """Whether the check, not the solver, finds the trajectory feasible."""
        return self.violation <= check.FEASIBLE

    @property
    def refined(self) -> bool:
        """Feasible and a minimum: the solver's word is needed for the second, and never enough for the first."""
        return self.feasible and self.solver_status in _CONVERGED


class Refiner:
    """The artifact's problem as a solver, built once.

    Raises ImportError without CasADi, ArtifactError when the problem is damaged or does not fit the manifest.
    """

    def __init__(self, folder: Path, manifest: Manifest, tensors: GaitTensors) -> None:
        casadi = _casadi()
        self._manifest = manifest
        self._tensors = tensors
        self._function = load_problem(folder, manifest)
        w, task = casadi.SX.sym("w", manifest.layout.variables), casadi.SX.sym("task", 2)
        cost, rows = self._function(w, task)
        self._solver = casadi.nlpsol(
            "refine", "ipopt", {"x": w, "p": task, "f": cost, "g": rows}, _options(manifest.solver_options)
        )

    def solve(self, gait: int, speed: float, cycle_duration: float) -> Attempt:
        """Solve gait number `gait` for a task (m/s, s) from its primal and dual warm start."""
        tensors, task = self._tensors, np.array([speed, cycle_duration])
        w, iterations = tensors.primal[gait], 0
        with _SOLVING:
            try:
                answer = self._solver(
                    x0=w, p=task,
                    lbx=tensors.lower_bounds[gait], ubx=tensors.upper_bounds[gait],
                    lbg=tensors.lower_rows[gait], ubg=tensors.upper_rows[gait],
                    lam_x0=tensors.multipliers_bounds[gait], lam_g0=tensors.multipliers_rows[gait],
                )  # fmt: skip
                statistics = self._solver.stats()
                status, iterations = str(statistics["return_status"]), int(statistics.get("iter_count", 0))
                w = np.asarray(answer["x"], dtype=float).ravel()
            except RuntimeError as error:
                status = f"the solver failed: {str(error).strip().splitlines()[-1][:200]}"
            cost = float(self._function(w, task)[0]) * self._manifest.cost_scale
        return self._judge(gait, speed, cycle_duration, w, cost, iterations, status)

    def _judge(
        self, gait: int, speed: float, cycle_duration: float, w: Array, cost: float, iterations: int, status: str
    ) -> Attempt:
        manifest = self._manifest
        trajectory = unpack(manifest.layout, self._tensors.scale, w, cycle_duration)
        pattern = manifest.gaits[gait].pattern
        violation = check.worst(manifest.scenario, trajectory, speed, cycle_duration, pattern)
        return Attempt(trajectory, cost, violation, iterations, status)


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
    ipopt = {**WARM_START, **options, "linear_solver": "mumps", "print_level": 0, "sb": "yes"}
    return {"ipopt": ipopt, "print_time": False, "error_on_fail": False, "show_eval_warnings": False}


def _casadi() -> Any:
    try:
        import casadi
    except ImportError:
        raise ImportError('refining a plan needs CasADi: pip install "gaitflow[solve]"') from None
    return casadi
