"""The map's problem, transcribed anew from its scenario; IPOPT for it, where the fast method does not converge.

A map is data: it holds its scenario, and the values of its problem at three points. The installed gaitflow
transcribes the scenario and has to find the same values there. Older maps hold code instead, see `legacy`.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from reprlib import repr as short
from typing import TYPE_CHECKING, Any

import gaitflow
from gaitflow.core.errors import ArtifactError
from gaitflow.core.task import Task
from gaitflow.core.trajectory import Array
from gaitflow.runtime import legacy
from gaitflow.runtime.files import MANIFEST, PROBLEM_CHECK, read_checked
from gaitflow.runtime.manifest import FORMAT, Manifest
from gaitflow.runtime.problem_check import EQUAL, parse_problem_check
from gaitflow.solvers.options import IPOPT_WARM
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import derivatives

if TYPE_CHECKING:
    from gaitflow.config.robot import Robot
    from gaitflow.problem import SeparableProblem

# IPOPT with MUMPS crashes when two threads of one process solve at once (casadi issue 3456).
_SOLVING = threading.Lock()


@dataclass(frozen=True)
class IpoptAnswer:
    """Where IPOPT ended, w [nw], and what it said; a solve that threw leaves its start, with 0 iterations."""

    w: Array
    iterations: int
    status: str


class Problem:
    """A map's problem with its derivatives, shared by all threads. Raises what `load_problem` does."""

    def __init__(self, folder: Path, manifest: Manifest, rows: int, trust_code: bool = False) -> None:
        self._manifest, self._where = manifest, folder / MANIFEST
        self.separable = load_problem(folder, manifest, rows, trust_code)
        self.derivatives = derivatives(self.separable)

    def ipopt(self, space: GaitSpace, task: Array, primal: Array, bounds: Array, rows: Array) -> IpoptAnswer:
        """Solve a gait at a task [axes] from a decision vector [nw] and multipliers of bounds [nw] and rows [ng].

        One call at a time in the whole process. Raises ArtifactError for options of the map that IPOPT does not take.
        """
        from gaitflow.solvers.ipopt import call_solver

        with _SOLVING:
            arguments = {
                "x0": primal, "p": task, "lbx": space.lower, "ubx": space.upper, "lbg": space.lower_rows,
                "ubg": space.upper_rows, "lam_x0": bounds, "lam_g0": rows,
            }  # fmt: skip
            status, iterations, result = call_solver(self._ipopt, arguments)
        return IpoptAnswer(result["x"], iterations, status)

    def cost(self, w: Array, task: Array) -> float:
        """The problem's cost of w [nw] at a task [axes]."""
        return float(self.separable.function(w, task)[0])

    def nominal(self, task: Task) -> Array:
        """The decision vector [nw] of an upright glide along the command, where the map's searches started, too."""
        from gaitflow.search.starts import nominal

        return nominal(self._robot, self._manifest.layout, task)

    @cached_property
    def _robot(self) -> Robot:
        from gaitflow.config.robot import Robot

        return Robot.from_data(self._manifest.scenario["robot"], f"{self._where}: scenario.robot")

    @cached_property
    def _ipopt(self) -> Any:
        from gaitflow.solvers.ipopt import make_ipopt

        try:
            return make_ipopt(self.separable.function, {**IPOPT_WARM, "max_iter": 300, **self._manifest.solver_options})
        except RuntimeError as error:  # its own ranges are narrower than what a manifest may say
            reason, given = str(error).strip().splitlines()[-1][-120:], short(dict(self._manifest.solver_options))
            raise ArtifactError(
                f"{self._where}: solver.options = {given}: IPOPT does not take these ({reason}); publish the map again"
            ) from None


def load_problem(folder: Path, manifest: Manifest, rows: int, trust_code: bool = False) -> SeparableProblem:
    """The problem (w [nw], task [axes]) -> (cost [1], rows [ng]) of the map in `folder`.

    `rows` is ng; `trust_code` allows to run the code in maps of formats 1 and 2.
    Raises ImportError without gaitflow[solve], ArtifactError when the problem cannot be had or is not the one that was
    published.
    """
    _need_solvers()
    from gaitflow.config.file import ConfigError
    from gaitflow.config.scenario import Scenario
    from gaitflow.problem import SeparableProblem, transcribe

    here, there = gaitflow.__version__, manifest.gaitflow_version
    try:
        scenario = Scenario.from_data(manifest.scenario, f"{folder / MANIFEST}: scenario")
    except ConfigError as error:
        raise ArtifactError(f"{error}; it was published by gaitflow {there}, this is {here}") from None
    if manifest.format < FORMAT:
        return SeparableProblem(legacy.stored_problem(folder, manifest, rows, trust_code))

    path = folder / PROBLEM_CHECK
    stored = parse_problem_check(
        read_checked(folder, PROBLEM_CHECK, manifest.files[PROBLEM_CHECK]), manifest.layout, rows, str(path)
    )
    problem = transcribe(scenario)
    fault = stored.differs(problem.nlp)
    if fault is None and abs(problem.cost_scale - manifest.cost_scale) > EQUAL * manifest.cost_scale:
        fault = f"the cost's scale is {problem.cost_scale:g} instead of {manifest.cost_scale:g}"
    if fault is not None:
        raise ArtifactError(
            f"{path}: of this map's scenario gaitflow {here}, which is installed, makes another problem than gaitflow "
            f"{there} made, which published it: {fault}; install gaitflow {there}, or publish the map again"
        )
    return problem.separable


def _need_solvers() -> None:
    try:
        import casadi  # noqa: F401
        import pydantic  # noqa: F401
        import qdldl  # noqa: F401
        import scipy.sparse  # noqa: F401
    except ImportError as missing:
        raise ImportError(f'refining a plan needs {missing.name}: pip install "gaitflow[solve]"') from None
