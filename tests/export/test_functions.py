"""What CasADi writes as C: which names it declares, and that equal problems give equal files. test_cpp.py runs it."""

from __future__ import annotations

import re

import casadi
import numpy as np
import pytest
from tiny_map import TinyMap

from gaitflow.export.functions import c_files, identifier


@pytest.mark.parametrize(
    ("scenario", "name"),
    [
        ("half-cheetah-flat-effort", "half_cheetah_flat_effort"),
        ("slope20", "slope20"),
        ("3d-trot", "map_3d_trot"),
        ("a--b.", "a_b"),
        ("...", "map"),
    ],
)
def test_a_scenario_becomes_a_name_in_c(scenario: str, name: str) -> None:
    assert identifier(scenario) == name
    x = casadi.SX.sym("x")
    assert casadi.Function(f"{identifier(scenario)}_problem", [x], [x]).name() == f"{name}_problem"


def test_every_name_begins_with_the_map_and_equal_problems_give_equal_files(tiny: TinyMap) -> None:
    robot, layout = tiny.problem.scenario.robot, tiny.problem.layout
    feet = np.array([leg.default_foot for leg in robot.legs])
    files = c_files(tiny.problem.separable, layout, feet, "my-map")
    assert sorted(files) == [
        "hessian.c", "hessian.h", "jacobian.c", "jacobian.h", "map.h", "problem.c", "problem.h",
    ]  # fmt: skip
    for name, content in files.items():
        if name.endswith(".c"):
            defined = re.findall(rb"^CASADI_SYMBOL_EXPORT [\w* ]*?(\w+)\(", content, flags=re.MULTILINE)
            assert defined and all(each.startswith(b"my_map_") for each in defined), name
    assert b"#define gaitflow_hessian my_map_hessian\n" in files["map.h"]
    assert b"my_map_gradient(const casadi_real** arg" in files["problem.h"]
    assert c_files(tiny.problem.separable, layout, feet, "my-map") == files
