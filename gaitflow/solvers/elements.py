"""Derivatives of a partially separable cost: those of one element, evaluated for each copy and added up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

if TYPE_CHECKING:
    from gaitflow.problem.separable import Element

Indices = NDArray[np.intp]


def with_elements(rest: Any, elements: Sequence[Element]) -> Any:
    """The function `rest`, as of `gaitflow.solvers.program.derivatives`, with the elements' cost added."""
    import casadi

    w, task, multipliers = (casadi.MX.sym(rest.name_in(i), rest.numel_in(i)) for i in range(3))
    cost, rows, gradient, jacobian, hessian = rest(w, task, multipliers)
    pairs = [_pairs(element) for element in elements]
    sparsity = hessian.sparsity()
    for row, column in pairs:
        sparsity += casadi.Sparsity.triplet(w.numel(), w.numel(), row.ravel().tolist(), column.ravel().tolist())
    values = casadi.project(hessian, sparsity).nz[:]
    places = np.array(sparsity.get_triplet())
    known = places[1] * w.numel() + places[0]  # ascending
    for element, (row, column) in zip(elements, pairs, strict=True):
        costs, slopes, curvatures = _evaluated(element, w, task)
        cost += costs
        gradient += _adding(element.places, element.weights, w.numel()) @ slopes
        values += _adding(np.searchsorted(known, column * w.numel() + row), element.weights, len(known)) @ curvatures
    results = [cost, rows, gradient, jacobian, casadi.MX(sparsity, values)]
    return casadi.Function("derivatives", [w, task, multipliers], results)


def _pairs(element: Element) -> tuple[Indices, Indices]:
    """Row and column [copies, entries] in the upper triangle of what each copy's second derivatives belong to."""
    rows, columns = (np.array(each, dtype=np.intp) for each in element.second.sparsity_out(1).get_triplet())
    one, other = element.places[:, rows], element.places[:, columns]
    return np.minimum(one, other), np.maximum(one, other)


def _evaluated(element: Element, w: Any, task: Any) -> tuple[Any, Any, Any]:
    """The cost, and for all copies one after the other gradients and second derivatives."""
    import casadi

    copies, n = element.places.shape
    x = casadi.reshape(w[element.places.ravel().tolist()], n, copies)
    costs = element.value.map("values", "serial", copies, [1], [])(x, task)
    function, arguments = element.second, [x, task]
    if element.gates is not None:
        shapes = [function.sparsity_out(i) for i in range(2)]
        symbols = [casadi.SX.sym("x", n), casadi.SX.sym("task", task.numel())]
        nothing = casadi.Function("nothing", symbols, [casadi.SX(shape, 0) for shape in shapes])
        function = casadi.Function.if_else("gated", function, nothing)
        arguments = [w[element.gates.tolist()].T, *arguments]
    slopes, curvatures = function.map("seconds", "serial", copies, [len(arguments) - 1], [])(*arguments)
    return costs @ casadi.DM(element.weights), casadi.vec(slopes), curvatures.nz[:]


def _adding(places: Indices, weights: Array, size: int) -> Any:
    """The matrix [size, copies * n] that adds each copy's n numbers, times its weight, at their places [copies, n]."""
    import casadi

    columns = np.arange(places.size)
    sparsity = casadi.Sparsity.triplet(size, places.size, places.ravel().tolist(), columns.tolist())
    return casadi.DM(sparsity, np.repeat(weights, places.shape[1]))
