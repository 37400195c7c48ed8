"""The artifact's problem with its first and second derivatives, evaluated into arrays that are never allocated anew."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.trajectory import Array

Places = tuple[NDArray[np.intp], NDArray[np.intp]]


def derivatives(problem: Any) -> Any:
    """The CasADi function (w [nw], task [2], multipliers [ng]) -> (cost, rows, gradient, Jacobian, Hessian).

    `problem` is the artifact's (w, task) -> (cost, rows); the Hessian is the upper triangle of the Lagrangian's,
    cost + multipliers @ rows. Built once a map; evaluating it takes no compiler.
    """
    import casadi

    w = casadi.SX.sym("w", problem.numel_in(0))
    task = casadi.SX.sym("task", problem.numel_in(1))
    multipliers = casadi.SX.sym("multipliers", problem.numel_out(1))
    cost, rows = problem(w, task)
    hessian, _ = casadi.hessian(cost + casadi.dot(multipliers, rows), w)
    gradient = casadi.densify(casadi.gradient(cost, w))
    results = [cost, rows, gradient, casadi.jacobian(rows, w), casadi.triu(hessian)]
    return casadi.Function("derivatives", [w, task, multipliers], results)


class Program:
    """One evaluation at a time of `derivatives`; its arrays hold the last one's values. For one thread.

    cost [1], rows [ng], gradient [nw]; jacobian and hessian are the values of fixed places, (row, column) each:
    `jacobian_places` and, upper triangle, `hessian_places`.
    """

    def __init__(self, function: Any) -> None:
        self.variables, self.row_count = function.numel_in(0), function.numel_in(2)
        self.jacobian_places = _places(function.sparsity_out(3))
        self.hessian_places = _places(function.sparsity_out(4))
        self._inputs = [np.zeros(function.numel_in(i)) for i in range(function.n_in())]
        self.cost, self.rows, self.gradient, self.jacobian, self.hessian = (
            np.zeros(function.nnz_out(i)) for i in range(function.n_out())
        )
        self._buffer, self._evaluate = (
            function.buffer()
        )  # a buffer has a memory of its own, so threads may each have one
        for index, array in enumerate(self._inputs):
            self._buffer.set_arg(index, array.data)
        for index, array in enumerate((self.cost, self.rows, self.gradient, self.jacobian, self.hessian)):
            self._buffer.set_res(index, array.data)

    def evaluate(self, w: Array, task: Array, multipliers: Array) -> None:
        """Evaluate all at w [nw], task [2] = (v, T) and multipliers [ng]."""
        for array, value in zip(self._inputs, (w, task, multipliers), strict=True):
            array[:] = value
        self._evaluate()


def _places(sparsity: Any) -> Places:
    rows, columns = sparsity.get_triplet()
    return np.asarray(rows, dtype=np.intp), np.asarray(columns, dtype=np.intp)
