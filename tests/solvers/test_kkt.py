from __future__ import annotations

import numpy as np
import pytest
from tasks_at import at

from gaitflow.solvers.kkt import DUAL, PRIMAL, Kkt, NotFactorised
from gaitflow.solvers.point import GaitSpace
from gaitflow.solvers.program import Program

TASK, UNIT = at(0.8, 0.7).parameters, 3.0
GAITS = ("walking", "gallop")


def evaluate(program: Program, solved: dict, gait: str, multipliers: float) -> None:
    """The program near the gait's start, with random multipliers of some size."""
    rng = np.random.default_rng(4)
    space = solved[gait].space
    w = solved[gait].attempt.w + 0.02 * rng.normal(size=program.variables)
    w = np.where(space.lower == space.upper, space.lower, w)
    program.evaluate(w, TASK, multipliers * rng.normal(size=program.row_count))


def dense(program: Program, space: GaitSpace, variables: np.ndarray, unequal: np.ndarray) -> np.ndarray:
    """The matrix of the module's picture with its small numbers, of which rows that join variables need none."""
    hessian = np.zeros((program.variables, program.variables))
    hessian[program.hessian_places] = program.hessian / UNIT
    hessian += np.triu(hessian, 1).T
    jacobian = np.zeros((program.row_count, program.variables))
    jacobian[program.jacobian_places] = program.jacobian
    rows = np.concatenate([space.equal, space.unequal])
    jacobian = jacobian[np.ix_(rows, space.free)]
    joins = [set(row[row != 0]) == {1.0, -1.0} and np.count_nonzero(row) == 2 for row in jacobian[: len(space.equal)]]
    corner = np.diag(np.concatenate([np.where(joins, 0.0, -DUAL), -unequal - DUAL]))
    return np.block(
        [[hessian[np.ix_(space.free, space.free)] + np.diag(variables + PRIMAL), jacobian.T], [jacobian, corner]]
    )


@pytest.mark.parametrize("gait", GAITS)
def test_solves_as_a_dense_matrix_does(program: Program, solved: dict, gait: str) -> None:
    space, rng = solved[gait].space, np.random.default_rng(0)
    kkt = Kkt(program, space)
    for multipliers in (0.0, 1e-3, 1e-2):  # the matrix is updated, not built anew
        evaluate(program, solved, gait, multipliers)
        variables, unequal = rng.uniform(0.5, 2, len(space.free)), rng.uniform(0.5, 2, len(space.unequal))
        right = rng.normal(size=len(space.free) + space.rows)
        expected = np.linalg.solve(dense(program, space, variables, unequal), right)
        kkt.factorise(UNIT, variables, unequal)
        found = kkt.solve(right)
        assert np.abs(found - expected).max() <= 1e-7 * np.abs(expected).max()


@pytest.mark.parametrize("gait", GAITS)
def test_transposed_jacobian_is_the_gaits_part(program: Program, solved: dict, gait: str) -> None:
    space = solved[gait].space
    kkt = Kkt(program, space)
    evaluate(program, solved, gait, 1.0)
    multipliers = np.random.default_rng(1).normal(size=space.rows)
    matrix = dense(program, space, np.zeros(len(space.free)), np.zeros(len(space.unequal)))
    expected = matrix[: len(space.free), len(space.free) :] @ multipliers
    np.testing.assert_allclose(kkt.transposed_jacobian(multipliers), expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("gait", GAITS)
def test_an_indefinite_hessian_is_corrected(program: Program, solved: dict, gait: str) -> None:
    space, free = solved[gait].space, len(solved[gait].space.free)
    kkt = Kkt(program, space)
    evaluate(program, solved, gait, 0.1)
    variables, unequal = np.zeros(free), np.full(len(space.unequal), 1e3)
    right = np.random.default_rng(2).normal(size=free + space.rows)
    matrix = dense(program, space, variables, unequal)
    assert (np.linalg.eigvalsh(matrix) < 0).sum() > space.rows, "H is not indefinite where it matters"
    kkt.factorise(UNIT, variables, unequal, correct=True)
    found = kkt.solve(right)
    missing = (right - matrix @ found)[:free]
    lift = missing @ found[:free] / (found[:free] @ found[:free])
    assert lift > 1e-5, "nothing was corrected"
    matrix[:free, :free] += lift * np.eye(free)
    assert (np.linalg.eigvalsh(matrix) < 0).sum() == space.rows
    np.testing.assert_allclose(matrix @ found, right, atol=1e-5 * np.abs(found).max())


def test_a_matrix_beyond_correction_is_said(program: Program, solved: dict) -> None:
    space = solved["gallop"].space
    kkt = Kkt(program, space)
    evaluate(program, solved, "gallop", 1e6)
    variables, unequal = np.zeros(len(space.free)), np.full(len(space.unequal), 1e3)
    right = np.ones(len(space.free) + space.rows)
    with pytest.raises(NotFactorised, match="no factorisation with"):
        kkt.factorise(UNIT, variables, unequal, correct=True)
    evaluate(program, solved, "gallop", 0.0)
    kkt.factorise(UNIT, variables + 1, unequal, correct=True)
    assert np.isfinite(kkt.solve(right)).all(), "the next one is not lost"


def test_what_is_not_a_number_has_no_factorisation(program: Program, solved: dict) -> None:
    space = solved["walking"].space
    kkt = Kkt(program, space)
    evaluate(program, solved, "walking", 0.0)
    program.hessian[:] = np.nan
    ones = np.ones(len(space.free))
    with pytest.raises(NotFactorised):
        kkt.factorise(UNIT, ones, ones[: len(space.unequal)], correct=True)
