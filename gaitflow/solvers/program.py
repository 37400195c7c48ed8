"""A problem with its first and second derivatives, evaluated into arrays that are never allocated anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.solvers.elements import with_elements

if TYPE_CHECKING:
    from gaitflow.problem import SeparableProblem

KEPT = 8  # functions that a process keeps, since they take seconds to build in space
Places = tuple[NDArray[np.intp], NDArray[np.intp]]


@lru_cache(maxsize=KEPT)
def derivatives(problem: SeparableProblem) -> Any:
    """The CasADi function (w [nw], task [axes], multipliers [ng]) -> (cost, rows, gradient, Jacobian, Hessian).

    The Hessian is the upper triangle of the Lagrangian's, cost + multipliers @ rows. Evaluating it takes no compiler.
    """
    rest = _rest_derivatives(problem.rest)
    return with_elements(rest, problem.elements) if problem.elements else rest


def _rest_derivatives(problem: Any) -> Any:
    import casadi

    w = casadi.SX.sym("w", problem.numel_in(0))
    task = casadi.SX.sym("task", problem.numel_in(1))
    multipliers = casadi.SX.sym("multipliers", problem.numel_out(1))
    cost, rows = casadi.cse(problem(w, task))  # an eighth less to evaluate in space
    hessian, _ = casadi.hessian(cost + casadi.dot(multipliers, rows), w)
    gradient = casadi.densify(casadi.gradient(cost, w))
    results = [cost, rows, gradient, casadi.jacobian(rows, w), casadi.triu(hessian)]
    return casadi.Function("derivatives", [w, task, multipliers], results)


class Program:
    """A problem and its derivatives. For one thread.

    Arrays hold the values of the last evaluation: cost [1], rows [ng], gradient [nw]; jacobian and hessian are the
    values of fixed places, (row, column) each: `jacobian_places` and, upper triangle, `hessian_places`. Programs of one
    problem may share its `derivatives`, which take seconds to build in space.
    """

    def __init__(self, problem: SeparableProblem, function: Any | None = None) -> None:
        function = derivatives(problem) if function is None else function
        self._problem = problem.function
        self.variables, self.row_count = function.numel_in(0), function.numel_in(2)
        self.jacobian_places = _places(function.sparsity_out(3))
        self.hessian_places = _places(function.sparsity_out(4))
        self._inputs = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self.cost, self.rows, self.gradient, self.jacobian, self.hessian = (
            np.zeros(function.nnz_out(i)) for i in range(function.n_out())
        )
        every = [self.cost, self.rows, self.gradient, self.jacobian, self.hessian]
        self._buffers: list[Any] = []  # which have to live as long as what evaluates into them
        self._evaluate = self._bound(function, self._inputs, every)
        self._evaluate_rows = self._bound(self._problem, self._inputs[:2], every[:2])

    def evaluate(self, w: Array, task: Array, multipliers: Array) -> None:
        """Evaluate all at w [nw], task [axes] and multipliers [ng]."""
        for array, value in zip(self._inputs, (w, task, multipliers), strict=True):
            array[:] = value
        self._evaluate()

    def evaluate_rows(self, w: Array, task: Array) -> None:
        """Evaluate cost and rows only, in an eighth of the time in space."""
        self._inputs[0][:], self._inputs[1][:] = w, task
        self._evaluate_rows()

    def by_task(self, w: Array, task: Array, multipliers: Array) -> tuple[Array, Array]:
        """How the gradient of cost + multipliers @ rows [nw, axes] and the rows [ng, axes] change with the task."""
        gradient, rows = self._task_derivatives(w, task, multipliers)
        return np.asarray(gradient.full()), np.asarray(rows.full())

    @cached_property
    def _task_derivatives(self) -> Any:
        import casadi

        symbols = [casadi.SX.sym("w", self.variables), casadi.SX.sym("task", self._problem.numel_in(1))]
        multipliers = casadi.SX.sym("multipliers", self.row_count)
        cost, rows = self._problem(*symbols)
        gradient = casadi.gradient(cost + casadi.dot(multipliers, rows), symbols[0])
        results = [casadi.jacobian(gradient, symbols[1]), casadi.jacobian(rows, symbols[1])]
        return casadi.Function("by_task", [*symbols, multipliers], results)

    def _bound(self, function: Any, inputs: Sequence[Array], results: Sequence[Array]) -> Callable[[], None]:
        """The function between these arrays; its buffer has a memory of its own, so threads may each have one."""
        buffer, evaluate = function.buffer()
        for index, array in enumerate(inputs):
            buffer.set_arg(index, array.data)
        for index, array in enumerate(results):
            buffer.set_res(index, array.data)
        self._buffers.append(buffer)
        return evaluate


def _places(sparsity: Any) -> Places:
    rows, columns = sparsity.get_triplet()
    return np.asarray(rows, dtype=np.intp), np.asarray(columns, dtype=np.intp)
