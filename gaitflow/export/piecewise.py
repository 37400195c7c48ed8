"""A program's functions where its terms are copies of a few: their code, loops over them, and where values belong.

As one expression, the derivatives of all steps are half a million lines of C in space. A compiler takes minutes and
gigabytes for them, and a processor takes most of a millisecond to read them. Those of one step fit in its cache.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import casadi
import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array

if TYPE_CHECKING:
    from gaitflow.problem.copies import Copies, Pieces
    from gaitflow.problem.separable import Element, SeparableProblem

Indices = NDArray[np.intp]
Places = tuple[Indices, Indices]  # rows, columns


@dataclass(frozen=True)
class _Values:
    """Numbers, one a place, that are part of a result; numbers at one place are added."""

    numbers: Any
    places: Places
    weights: Array


@dataclass(frozen=True)
class _Part:
    """One term of the program, or all copies of one: its values in each of the results."""

    cost: _Values
    rows: _Values
    gradient: _Values
    jacobian: _Values
    hessian: _Values


def piecewise(problem: SeparableProblem, pieces: Pieces) -> dict[str, tuple[list[Any], list[Any]]]:
    """Inputs (w, task, and the Hessian's multipliers) and results, as CasADi's MX, of the four functions by name.

    `problem`: cost and rows; `gradient`, `jacobian`, `hessian`: as of `gaitflow.solvers.program.derivatives`.
    """
    w, task = (casadi.MX.sym(name, pieces.rest.numel_in(i)) for i, name in enumerate(("w", "task")))
    multipliers = casadi.MX.sym("multipliers", pieces.rest.numel_out(1))
    parts = [
        _rest(pieces.rest, w, task, multipliers),
        *(_copies(copies, w, task, multipliers) for copies in pieces.copies),
        *(_element(element, w, task) for element in problem.elements),
    ]
    n, m = w.numel(), multipliers.numel()
    cost, rows = _sum([part.cost for part in parts], 1, 1), _sum([part.rows for part in parts], m, 1)
    return {
        "problem": ([w, task], [casadi.densify(cost), casadi.densify(rows)]),
        "gradient": ([w, task], [casadi.densify(_sum([part.gradient for part in parts], n, 1))]),
        "jacobian": ([w, task], [_sum([part.jacobian for part in parts], m, n)]),
        "hessian": ([w, task, multipliers], [_sum([part.hessian for part in parts], n, n)]),
    }


def _sum(parts: Sequence[_Values], rows: int, columns: int) -> Any:
    """The sparse matrix of all values: the first two of a place are gathered, further ones a sparse product adds."""
    flat = np.concatenate([part.places[1] * rows + part.places[0] for part in parts])  # as CasADi keeps them
    known, first, place, count = np.unique(flat, return_index=True, return_inverse=True, return_counts=True)
    zero = len(flat)
    numbers = casadi.vertcat(*(_weighted(part) for part in parts), casadi.MX(1, 1))
    total = numbers[first.tolist()]
    order = np.argsort(place, kind="stable")  # all numbers of the first place, those of the second one, ...
    starts = np.cumsum(count) - count
    if len(known) and count.max() > 1:
        total += numbers[np.where(count > 1, order[np.minimum(starts + 1, zero - 1)], zero).tolist()]
    further = order[np.arange(len(order)) - np.repeat(starts, count) > 1]
    if len(further):
        many = np.flatnonzero(count > 2)
        to = np.searchsorted(many, place[further]).tolist()
        adding = casadi.Sparsity.triplet(len(many), len(further), to, list(range(len(further))))
        total[many.tolist()] += casadi.DM(adding, 1.0) @ numbers[further.tolist()]
    return casadi.MX(casadi.Sparsity.triplet(rows, columns, (known % rows).tolist(), (known // rows).tolist()), total)


def _weighted(part: _Values) -> Any:
    return part.numbers if np.all(part.weights == 1) else part.numbers * casadi.DM(part.weights)


def _rest(rest: Any, w: Any, task: Any, multipliers: Any) -> _Part:
    symbols = [casadi.SX.sym(rest.name_in(i), rest.numel_in(i)) for i in range(2)]
    pushes = casadi.SX.sym("multipliers", multipliers.numel())
    functions = _derived("rest", symbols, pushes, rest(*symbols), symbols[0])

    def values(name: str) -> _Values:
        function = functions[name]
        result = function(*[w, task, multipliers][: function.n_in()])
        places = _triplets(result.sparsity())
        return _Values(casadi.vec(result.nz[:]), places, np.ones(len(places[0])))

    return _Part(*(values(name) for name in ("cost", "rows", "gradient", "jacobian", "hessian")))


def _copies(copies: Copies, w: Any, task: Any, multipliers: Any) -> _Part:
    count = len(copies.places)
    symbols = [casadi.SX.sym(f"in_{i}", copies.function.numel_in(i)) for i in range(3)]
    pushes = casadi.SX.sym("multipliers", copies.rows.shape[1])
    functions = _derived("copy", symbols, pushes, list(copies.function(*symbols)), symbols[0])
    arguments = [_gathered(w, copies.places), casadi.MX(casadi.DM(copies.data.T)), task]
    arguments.append(_gathered(multipliers, copies.rows))
    nowhere = np.zeros((count, 1), dtype=np.intp)

    def values(name: str, rows: Indices, columns: Indices) -> _Values:
        function = functions[name]
        row, column = _triplets(function.sparsity_out(0))
        places = _upper(rows[:, row], columns[:, column]) if name == "hessian" else (rows[:, row], columns[:, column])
        each = function.map(f"{name}_of_copies", "serial", count, [2], [])(*arguments[: function.n_in()])
        return _Values(casadi.vec(each.nz[:]), (places[0].ravel(), places[1].ravel()), np.ones(places[0].size))

    return _Part(
        cost=values("cost", nowhere, nowhere),
        rows=values("rows", copies.rows, nowhere),
        gradient=values("gradient", copies.places, nowhere),
        jacobian=values("jacobian", copies.rows, copies.places),
        hessian=values("hessian", copies.places, copies.places),
    )


def _element(element: Element, w: Any, task: Any) -> _Part:
    copies, n = element.places.shape
    x, gates = _gathered(w, element.places), None if element.gates is None else w[element.gates.tolist()].T
    symbols = [casadi.SX.sym("x", n), casadi.SX.sym("task", task.numel())]
    slope, curvature = element.second(*symbols)
    nowhere = np.zeros((copies, 1), dtype=np.intp)

    def values(name: str, result: Any, gated: bool, rows: Indices, columns: Indices) -> _Values:
        function, arguments = casadi.Function(f"{name}_of_element", symbols, [result], {"cse": True}), [x, task]
        if gated and gates is not None:
            nothing = casadi.Function("nothing", symbols, [casadi.SX(result.sparsity(), 0)])
            function, arguments = casadi.Function.if_else(f"{name}_gated", function, nothing), [gates, *arguments]
        row, column = _triplets(function.sparsity_out(0))
        places = _upper(rows[:, row], columns[:, column]) if name == "hessian" else (rows[:, row], columns[:, column])
        each = function.map(f"{name}_of_elements", "serial", copies, [len(arguments) - 1], [])(*arguments)
        weights = np.repeat(element.weights, len(row))
        return _Values(casadi.vec(each.nz[:]), (places[0].ravel(), places[1].ravel()), weights)

    empty = np.zeros(0, dtype=np.intp)
    nothing = _Values(casadi.MX(0, 1), (empty, empty), np.zeros(0))
    return _Part(
        cost=values("cost", element.value(*symbols), False, nowhere, nowhere),
        rows=nothing,
        gradient=values("gradient", slope, True, element.places, nowhere),
        jacobian=nothing,
        hessian=values("hessian", curvature, True, element.places, element.places),
    )


def _derived(name: str, inputs: Sequence[Any], multipliers: Any, results: Sequence[Any], x: Any) -> dict[str, Any]:
    """Each result as a function of the inputs, the Hessian of multipliers, too."""
    cost, rows = casadi.cse(list(results))
    hessian, _ = casadi.hessian(cost + casadi.dot(multipliers, rows), x)
    found = {
        "cost": cost,
        "rows": rows,
        "gradient": casadi.gradient(cost, x),
        "jacobian": casadi.jacobian(rows, x),
        "hessian": casadi.triu(hessian),
    }
    return {
        each: casadi.Function(
            f"{each}_of_{name}", [*inputs, multipliers] if each == "hessian" else list(inputs), [result], {"cse": True}
        )
        for each, result in found.items()
    }


def _gathered(vector: Any, places: Indices) -> Any:
    """The vector's numbers at places [copies, n], a column a copy."""
    return casadi.reshape(vector[places.ravel().tolist()], places.shape[1], places.shape[0])


def _triplets(sparsity: Any) -> Places:
    row, column = (np.array(each, dtype=np.intp) for each in sparsity.get_triplet())
    return row, column


def _upper(rows: Indices, columns: Indices) -> Places:
    return np.minimum(rows, columns), np.maximum(rows, columns)
