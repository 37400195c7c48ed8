"""A residual that is not a number is not forgotten by the C++ planner; needs g++."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path

import pytest

import gaitflow.export

pytestmark = pytest.mark.slow

HEADERS = Path(gaitflow.export.__file__).parent / "cpp"
SOURCE = Path(__file__).parent / "residuals.cpp"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert shutil.which("g++"), "g++ is missing, so the export cannot be tested: apt-get install g++"
    built = tmp_path_factory.mktemp("program") / "program"
    command = ["g++", "-std=c++17", "-O2", "-Wall", "-Wextra", "-Werror", f"-I{HEADERS}", str(SOURCE)]
    done = subprocess.run([*command, "-o", str(built)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return built


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
