"""A residual that is not a number is not forgotten by the C++ planner; needs g++."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest
from cpp_program import compiled

pytestmark = pytest.mark.slow

SOURCE = Path(__file__).parent / "residuals.cpp"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(SOURCE, tmp_path_factory.mktemp("program"), "-O2")


@pytest.mark.parametrize(
    ("residuals", "largest"),
    [
        ((0.5, -2.0, 1.0), 2.0),
        ((math.inf, 1.0), math.inf),
        ((math.nan,), math.nan),
        ((3.0, math.nan, 1.0), math.nan),
        ((math.nan, 1e300), math.nan),
        ((1.0, -math.nan), math.nan),
    ],
)
def test_largest_residual_is_lost_where_one_is(program: Path, residuals: tuple[float, ...], largest: float) -> None:
    done = subprocess.run([str(program), *map(str, residuals)], capture_output=True, text=True, check=True)
    assert float(done.stdout) == pytest.approx(largest, nan_ok=True)
