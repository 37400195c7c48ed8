"""Short inequality rows are left out of the C++ planner's matrix without a change of its solution; needs g++."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from cpp_program import compiled

pytestmark = pytest.mark.slow

SOURCE = Path(__file__).parent / "short_rows.cpp"
UNKNOWNS, EQUAL = 20, 6
MET = (0, 1, 2, 5, 9, 10, 11, 15)  # unknowns that each inequality row meets; up to ten are few


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(SOURCE, tmp_path_factory.mktemp("program"), "-O1", "-g", "-fsanitize=address,undefined")


@pytest.mark.parametrize("seed", range(5))
def test_solution_equals_that_of_the_whole_matrix(program: Path, seed: int) -> None:
    random = np.random.default_rng(seed)
    root = random.normal(size=(UNKNOWNS, UNKNOWNS))
    hessian = root @ root.T
    equal, unequal = random.normal(size=(EQUAL, UNKNOWNS)), np.zeros((len(MET), UNKNOWNS))
    for row, count in zip(unequal, MET, strict=True):
        row[random.choice(UNKNOWNS, count, replace=False)] = random.uniform(0.5, 1.5, count)
    jacobian = np.vstack([equal, unequal])
    corner = -np.concatenate([np.full(EQUAL, 0.01), random.uniform(0.1, 10, len(MET))])
    right = random.normal(size=UNKNOWNS + len(corner))
    given = np.concatenate([hessian.ravel(), jacobian.ravel(), corner, right])
    text = f"{UNKNOWNS} {EQUAL} {len(MET)}\n" + " ".join(repr(float(each)) for each in given)
    done = subprocess.run([str(program)], input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *found, short = (float(line) for line in done.stdout.splitlines())
    matrix = np.block([[hessian, jacobian.T], [jacobian, np.diag(corner)]])
    np.testing.assert_allclose(found, np.linalg.solve(matrix, right), rtol=1e-9, atol=1e-9)
    assert short == sum(0 < count <= 10 for count in MET)
