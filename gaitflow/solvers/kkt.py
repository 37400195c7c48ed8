"""The KKT matrix of one gait: one sparsity, one ordering, one symbolic factorisation, however often it is solved.

    [ H + D_w      J_E^T      J_I^T    ]   variables that the gait leaves free
    [ J_E         -d                   ]   equality rows
    [ J_I                     -D_I     ]   inequality rows, their slacks eliminated

Swing forces, stance velocities and rows without a free variable are not in it, which halves the problem. Variables
that move together are one unknown, and the rows that join them are left out (see `paths`), which halves the factors.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gaitflow.core.task import AXES
from gaitflow.core.trajectory import Array
from gaitflow.solvers.paths import Places, find_paths
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import Program

DUAL = 1e-8  # -d: keeps multipliers from running away where the rows of a periodic motion depend on each other
PRIMAL = 1e-6  # added to H's diagonal: J1 does not see positions, and its H alone has no inverse
# A diagonal that does not do is raised: at first to a third of what did the last time, or the least, then by a factor.
LEAST_LIFT, RAISE, CORRECTIONS = 1e-4, 8.0, 12
ROUNDING = 1e-14  # of right sides
# Solutions are corrected this often by what they leave of the right side. Without, the pivots of 1e-8 lose half of the
# digits: a plan moves by 1e-5, some by 1e-2, when the last bit of its task changes. With one by 1e-9, with two 1e-11;
# each takes a sixth of a solve's time in the plane.
REFINEMENTS = 1


class NotFactorised(ArithmeticError):
    """The matrix has no factorisation LDL^T without pivoting."""


class Kkt:
    """The matrix of a gait in its space. For one thread. Raises ImportError without qdldl and scipy."""

    def __init__(self, program: Program, space: GaitSpace) -> None:
        self._program = program
        self._space = space
        self._free, self._rows = len(space.free), space.rows
        self._find_entries()
        self._join()
        self._build()
        self._solver = self._ordered()
        self.last_lift = 0.0  # what H's diagonal was raised by; to be set to 0 where a run begins
        self._hessian, self._jacobian = np.zeros(len(self._from_hessian)), np.zeros(len(self._from_jacobian))
        self._diagonal, self._corner = np.zeros(self._free), np.zeros(self._rows)

    def transposed_jacobian(self, multipliers: Array) -> Array:
        """J^T @ multipliers [nF] at the program's last point; multipliers [nE + nI], equality rows first."""
        weights = self._program.jacobian[self._from_jacobian] * multipliers[self._jacobian_row]
        return np.bincount(self._jacobian_column, weights, minlength=self._free).astype(np.float64)

    def factorise(self, unit: float, variables: Array, unequal: Array, correct: bool = False) -> None:
        """Factorise it with the program's Hessian over `unit`, D_w = variables [nF] and D_I = unequal [nI].

        `correct`: raise H's diagonal until the matrix has as many negative eigenvalues as rows, as it has at a minimum.
        Raises NotFactorised.
        """
        self._hessian = self._program.hessian[self._from_hessian] / unit
        self._jacobian = self._program.jacobian[self._from_jacobian]
        corner = np.concatenate([np.full(len(self._space.equal), -DUAL), -unequal - DUAL])[self._kept]
        self._corner[self._kept] = corner
        lift, raised = PRIMAL, max(LEAST_LIFT, self.last_lift / 3)
        for _ in range(CORRECTIONS):
            self._diagonal = variables + lift
            weights = [self._twice * self._hessian, self._jacobian[self._jacobian_kept], self._diagonal, corner]
            self._matrix.data[:] = np.bincount(self._slot, np.concatenate(weights), minlength=self._matrix.nnz)
            if self._factorised(correct):
                self.last_lift = lift if lift > PRIMAL else self.last_lift / 10
                return
            tried, lift, raised = lift, raised, raised * RAISE
        raise NotFactorised(f"no factorisation with {tried:g} on the diagonal")

    def solve(self, right: Array) -> Array:
        """The solution [nF + nE + nI] by the last factorisation; rows that join variables are met exactly."""
        solution = self._solved(right)
        for _ in range(REFINEMENTS):
            free, multipliers = np.split(solution, [self._free])
            variables, rows = self._times(free, multipliers, self._everything)
            solution = solution + self._solved(right - np.concatenate([variables, rows + self._corner * multipliers]))
        return solution

    def _solved(self, right: Array) -> Array:
        """The solution to the digits that the factors leave."""
        paths, groups = self._paths, self._groups
        offsets = paths.offsets(right[self._free :], self._free)
        reduced = right
        if np.abs(offsets).max(initial=0.0) > ROUNDING:
            variables, rows = self._times(offsets, np.zeros(self._rows), self._everything)
            reduced = right - np.concatenate([variables, rows])
        joined = np.bincount(groups, reduced[: self._free], minlength=self._unknowns)
        found = self._solver.solve(np.concatenate([joined, reduced[self._free :][self._kept]]))
        solution = np.zeros(len(right))
        solution[: self._free] = found[: self._unknowns][groups] + offsets
        solution[self._free + self._kept] = found[self._unknowns :]
        balanced, _ = self._times(solution[: self._free], solution[self._free :], self._of_paths)
        solution[self._free + paths.rows] = paths.multipliers(right[: self._free] - balanced)
        return solution

    def _times(self, variables: Array, multipliers: Array, entries: tuple[Places, Places]) -> tuple[Array, Array]:
        """(H + D_w) @ variables + J^T @ multipliers [nF], and J @ variables [nE + nI], of some entries of H and J."""
        of_hessian, of_jacobian = entries
        top, left, hessian = self._hessian_top[of_hessian], self._hessian_left[of_hessian], self._hessian[of_hessian]
        row, column, jacobian = (
            self._jacobian_row[of_jacobian],
            self._jacobian_column[of_jacobian],
            self._jacobian[of_jacobian],
        )
        below_diagonal = np.where(top == left, 0.0, hessian) * variables[top]
        products = [hessian * variables[left], below_diagonal, jacobian * multipliers[row]]
        sums = np.bincount(np.concatenate([top, left, column]), np.concatenate(products), minlength=self._free)
        rows = np.bincount(row, jacobian * variables[column], minlength=self._rows).astype(np.float64)
        return sums + self._diagonal * variables, rows

    def _find_entries(self) -> None:
        """Of H (upper triangle) and J: which of the program's values, and between which variables and rows.

        Many a value of the program is 0 whatever the motion, as a force or a velocity that the gait fixes is a factor.
        Those of two motions without any meaning tell which.
        """
        program, space, random = self._program, self._space, np.random.default_rng(0)
        variable, row = np.full(program.variables, -1), np.full(program.row_count, -1)
        variable[space.free] = np.arange(self._free)
        row[np.concatenate([space.equal, space.unequal])] = np.arange(self._rows)
        values = []
        for _ in range(2):
            w = space.fixed.copy()
            w[space.free] = random.uniform(0.1, 0.9, self._free)
            program.evaluate(w, random.uniform(0.1, 0.9, len(AXES)), random.normal(size=program.row_count))
            values.append((program.hessian.copy(), program.jacobian.copy()))
        (hessian, jacobian), (other_hessian, other_jacobian) = values
        top, left = (variable[places] for places in program.hessian_places)
        self._from_hessian = np.flatnonzero((top >= 0) & (left >= 0) & ((hessian != 0) | (other_hessian != 0)))
        self._hessian_top, self._hessian_left = top[self._from_hessian], left[self._from_hessian]
        row, column = row[program.jacobian_places[0]], variable[program.jacobian_places[1]]
        self._from_jacobian = np.flatnonzero((row >= 0) & (column >= 0) & ((jacobian != 0) | (other_jacobian != 0)))
        self._jacobian_row, self._jacobian_column = row[self._from_jacobian], column[self._from_jacobian]
        constant = np.where(jacobian == other_jacobian, jacobian, np.nan)[self._from_jacobian]
        equal = self._jacobian_row < len(space.equal)
        self._paths = find_paths(self._jacobian_row[equal], self._jacobian_column[equal], constant[equal])

    def _join(self) -> None:
        """Number the unknowns: groups of variables, and the rows that join none."""
        self._groups = self._paths.groups(self._free)
        self._unknowns = int(self._groups.max(initial=-1)) + 1
        keep = np.ones(self._rows, dtype=bool)
        keep[self._paths.rows] = False
        self._kept = np.flatnonzero(keep)
        self._jacobian_kept = keep[self._jacobian_row]
        moves = np.zeros(self._free, dtype=bool)
        moves[self._paths.nodes] = True
        self._everything = np.arange(len(self._from_hessian)), np.arange(len(self._from_jacobian))
        touching = moves[self._hessian_top] | moves[self._hessian_left]
        self._of_paths = np.flatnonzero(touching), np.flatnonzero(moves[self._jacobian_column] & self._jacobian_kept)

    def _build(self) -> None:
        """The matrix's upper triangle, and in which of its places every entry is added."""
        from scipy.sparse import csc_matrix

        size, number = self._unknowns + len(self._kept), np.zeros(self._rows, dtype=np.intp)
        number[self._kept] = self._unknowns + np.arange(len(self._kept))
        one, other = self._groups[self._hessian_top], self._groups[self._hessian_left]
        # Two variables that are one unknown meet on the diagonal, from both sides.
        self._twice = np.where((one == other) & (self._hessian_top != self._hessian_left), 2.0, 1.0)
        column, row = self._jacobian_column[self._jacobian_kept], self._jacobian_row[self._jacobian_kept]
        rows = [np.minimum(one, other), self._groups[column], self._groups, number[self._kept]]
        columns = [np.maximum(one, other), number[row], self._groups, number[self._kept]]
        places, self._slot = np.unique(np.concatenate(columns) * size + np.concatenate(rows), return_inverse=True)
        starts = np.searchsorted(places // size, np.arange(size + 1))
        indices = (places % size).astype(np.int32)
        self._matrix = csc_matrix((np.ones(len(places)), indices, starts.astype(np.int32)), shape=(size, size))

    def _ordered(self) -> Any:
        """A solver that knows the order and the places of the factors, of a matrix of these places and no meaning."""
        import qdldl

        size = self._matrix.shape[0]
        columns = np.repeat(np.arange(size), np.diff(self._matrix.indptr))
        signs = np.where(np.arange(size) < self._unknowns, 1.0, -1.0)
        self._matrix.data[:] = np.where(self._matrix.indices == columns, signs[columns], 0.0)
        return qdldl.Solver(self._matrix, upper=True)

    def _factorised(self, correct: bool) -> bool:
        try:
            self._solver.update(self._matrix, upper=True)
            if not correct:
                return True
            _, pivots, _ = self._solver.factors()
            signs = np.sign(pivots)
            return bool((signs < 0).sum() == len(self._kept) and (signs > 0).sum() == self._unknowns)
        except RuntimeError:  # a pivot of zero
            return False
