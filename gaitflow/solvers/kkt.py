"""The KKT matrix of one gait: one sparsity, one ordering, one symbolic factorisation, however often it is solved.

    [ H + D_w      J_E^T      J_I^T    ]   variables that the gait leaves free
    [ J_E         -d                   ]   equality rows
    [ J_I                     -D_I     ]   inequality rows, their slacks eliminated

Swing forces, stance velocities and rows without a free variable are not in it: a gait halves the problem.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitflow.core.trajectory import Array
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import Program

DUAL = 1e-8  # -d: keeps multipliers from running away where the rows of a periodic motion depend on each other
PRIMAL = 1e-6  # added to H's diagonal: J1 does not see positions, and its H alone has no inverse
CORRECTIONS = 6

Places = NDArray[np.intp]


class NotFactorised(ArithmeticError):
    """The matrix has no factorisation LDL^T without pivoting."""


class Kkt:
    """The matrix of a gait in its space. For one thread. Raises ImportError without qdldl and scipy."""

    def __init__(self, program: Program, space: GaitSpace) -> None:
        self._program = program
        self._space = space
        self._build(*self._entries())
        self._solver = self._ordered()

    def transposed_jacobian(self, multipliers: Array) -> Array:
        """J^T @ multipliers [nF] at the program's last point; multipliers [nE + nI], equality rows first."""
        weights = self._program.jacobian[self._from_jacobian] * multipliers[self._jacobian_row]
        return np.bincount(self._jacobian_column, weights, minlength=len(self._space.free)).astype(np.float64)

    def factorise(self, unit: float, variables: Array, unequal: Array, correct: bool = False) -> None:
        """Factorise it with the program's Hessian over `unit`, D_w = variables [nF] and D_I = unequal [nI].

        `correct`: raise H's diagonal until the matrix has as many negative eigenvalues as rows, as it has at a minimum.
        Raises NotFactorised.
        """
        diagonal = np.concatenate([variables + PRIMAL, np.full(len(self._space.equal), -DUAL), -unequal - DUAL])
        values, program = np.zeros(self._matrix.nnz), self._program
        values[self._hessian_slot] = program.hessian[self._from_hessian] / unit
        values[self._jacobian_slot] = program.jacobian[self._from_jacobian]
        values[self._diagonal_slot] += diagonal
        lifted, lift = self._diagonal_slot[: len(self._space.free)], PRIMAL
        for _ in range(CORRECTIONS):
            self._matrix.data[:] = values
            if self._factorised(correct):
                return
            values[lifted] += 99 * lift
            lift *= 100
        raise NotFactorised(f"no factorisation with {lift / 100:g} on the diagonal")

    def solve(self, right: Array) -> Array:
        """The solution [nF + nE + nI] by the last factorisation."""
        return self._solver.solve(right)

    def _entries(self) -> tuple[Places, Places]:
        """Rows and columns of all entries, upper triangle: of H, of J^T, and of the whole diagonal."""
        program, space, free = self._program, self._space, len(self._space.free)
        variable, row = np.full(program.variables, -1), np.full(program.row_count, -1)
        variable[space.free] = np.arange(free)
        row[np.concatenate([space.equal, space.unequal])] = np.arange(space.rows)
        top, left = program.hessian_places
        self._from_hessian = np.flatnonzero((variable[top] >= 0) & (variable[left] >= 0))
        of_row, of_variable = program.jacobian_places
        self._from_jacobian = np.flatnonzero((row[of_row] >= 0) & (variable[of_variable] >= 0))
        self._jacobian_row = row[of_row[self._from_jacobian]]
        self._jacobian_column = variable[of_variable[self._from_jacobian]]
        everything = np.arange(free + space.rows)
        rows = [variable[top[self._from_hessian]], self._jacobian_column, everything]
        columns = [variable[left[self._from_hessian]], self._jacobian_row + free, everything]
        return np.concatenate(rows), np.concatenate(columns)

    def _build(self, rows: Places, columns: Places) -> None:
        from scipy.sparse import csc_matrix

        size = len(self._space.free) + self._space.rows
        places, slots = np.unique(columns * size + rows, return_inverse=True)  # H and the diagonal share places
        starts = np.searchsorted(places // size, np.arange(size + 1))
        indices = (places % size).astype(np.int32)
        self._matrix = csc_matrix((np.ones(len(places)), indices, starts.astype(np.int32)), shape=(size, size))
        ends = np.cumsum([len(self._from_hessian), len(self._from_jacobian)])
        self._hessian_slot, self._jacobian_slot, self._diagonal_slot = np.split(slots, ends)

    def _ordered(self) -> Any:
        """A solver that knows the order and the places of the factors, of a matrix of these places and no meaning."""
        import qdldl

        self._matrix.data[:] = 0.0
        signs = np.where(np.arange(self._matrix.shape[0]) < len(self._space.free), 1.0, -1.0)
        self._matrix.data[self._diagonal_slot] = signs
        return qdldl.Solver(self._matrix, upper=True)

    def _factorised(self, correct: bool) -> bool:
        try:
            self._solver.update(self._matrix, upper=True)
            if not correct:
                return True
            _, pivots, _ = self._solver.factors()
            return int((np.asarray(pivots) < 0).sum()) == self._space.rows
        except RuntimeError:  # a pivot of zero
            return False
