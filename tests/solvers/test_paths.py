from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitflow.solvers.kkt import Kkt
from gaitflow.solvers.paths import Paths, find_paths
from gaitflow.solvers.program import Program

# Row, variable, value: 0-1-2 is a path, 5-3 another; row 4 has three entries, row 5 a 2, row 6 two of one sign.
ENTRIES = [
    (0, 1, 1.0), (0, 0, -1.0), (1, 1, -1.0), (1, 2, 1.0), (2, 3, 1.0), (2, 5, -1.0),
    (4, 0, 1.0), (4, 3, -1.0), (4, 5, 1.0), (5, 2, 2.0), (5, 3, -2.0), (6, 2, 1.0), (6, 4, 1.0),
]  # fmt: skip


def found(entries: list[tuple[int, int, float]]) -> Paths:
    rows, variables, values = (np.array(column) for column in zip(*entries, strict=True))
    return find_paths(rows, variables, values)


def matrix(entries: list[tuple[int, int, float]], variables: int) -> np.ndarray:
    dense = np.zeros((1 + max(row for row, _, _ in entries), variables))
    for row, variable, value in entries:
        dense[row, variable] = value
    return dense


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_entries_does_not_matter(seed: int) -> None:
    shuffled = [ENTRIES[at] for at in np.random.default_rng(seed).permutation(len(ENTRIES))]
    groups = found(shuffled).groups(6)
    assert groups[0] == groups[1] == groups[2]
    assert groups[3] == groups[5]
    assert len({groups[0], groups[3], groups[4]}) == 3
    assert set(groups) == {0, 1, 2}
    assert sorted(found(shuffled).rows) == [0, 1, 2]


def test_a_row_that_closes_a_ring_is_none_of_them() -> None:
    ring = [*ENTRIES[:4], (7, 2, 1.0), (7, 0, -1.0)]
    paths = found(ring)
    assert len(paths.rows) == 2
    assert len(set(paths.groups(3))) == 1


def test_a_variable_has_two_neighbours_at_most() -> None:
    paths = found([*ENTRIES[:4], (7, 1, 1.0), (7, 4, -1.0)])
    assert len(paths.rows) == 2
    assert paths.groups(5)[4] not in paths.groups(5)[:4]


def test_nothing_is_joined_where_no_row_joins() -> None:
    paths = find_paths(np.zeros(0, dtype=int), np.zeros(0, dtype=int), np.zeros(0))
    np.testing.assert_array_equal(paths.groups(3), [0, 1, 2])
    np.testing.assert_array_equal(paths.offsets(np.ones(4), 3), np.zeros(3))
    assert paths.multipliers(np.ones(3)).shape == (0,)


@given(st.integers(0, 2**32 - 1), st.integers(2, 12), st.integers(0, 15))
def test_rows_are_met_and_variables_balanced(seed: int, variables: int, rows: int) -> None:
    """Offsets solve J x = right for the rows of the paths; multipliers solve J^T y = left up to a sum a path."""
    rng = np.random.default_rng(seed)
    entries = []
    for row in range(rows):
        one, other = rng.choice(variables, 2, replace=False)
        sign = float(rng.choice([-1, 1]))
        entries += [(row, int(one), sign), (row, int(other), -sign)]
    if not entries:
        return
    paths = found(entries)
    joins = matrix(entries, variables)[paths.rows]
    right = rng.normal(size=rows)
    moved = paths.offsets(right, variables)
    np.testing.assert_allclose(joins @ moved, right[paths.rows], atol=1e-12)
    groups = paths.groups(variables)
    assert len(set(groups)) == variables - len(paths.rows), "every row joins two that were apart"
    assert np.abs(joins @ groups).max(initial=0) == 0
    left = rng.normal(size=variables)
    left -= (np.bincount(groups, left) / np.bincount(groups))[groups]
    np.testing.assert_allclose(joins.T @ paths.multipliers(left), left, atol=1e-12)


def test_a_gaits_feet_are_joined_while_they_stand(solved: dict, program: Program) -> None:
    """Walking, 0111/1101, 4 knots a phase: a foot stands at 13 knots, and the first of the cycle is its last, too."""
    kkt = Kkt(program, solved["walking"].space)
    sizes = np.bincount(kkt._groups)
    assert sorted(sizes)[-2:] == [14, 14]
