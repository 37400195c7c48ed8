"""The functions of a program in pieces are those of the program derived in one piece."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest

from gaitflow.config.scenario import Scenario, load_scenario
from gaitflow.export.piecewise import piecewise
from gaitflow.problem import transcribe
from gaitflow.solvers.program import derivatives

TURNING = {"yaw_rate": {"start": -0.5, "stop": 0.5, "count": 3}, "acceleration": 0.3}


def coarse(checkout: Path, name: str, axes: dict[str, Any]) -> Scenario:
    """A scenario on 2 knots a phase, with more axes."""
    data = load_scenario(checkout / "configs/scenarios" / f"{name}.yaml").as_data()
    data["transcription"]["knots_per_phase"] = 2
    data["tasks"]["axes"] |= axes
    return Scenario.from_data(data, name)


@pytest.mark.parametrize(
    ("name", "axes"),
    [
        ("half-cheetah-flat-effort", {}),
        ("half-cheetah-exact-slopes", {}),
        ("anymal-exact-vibration", TURNING),
        ("anymal-energy", {}),
    ],
    ids=["held forces", "slopes", "turning", "energy"],
)  # fmt: skip
def test_the_functions_are_those_of_the_program_in_one_piece(checkout: Path, name: str, axes: dict[str, Any]) -> None:
    problem = transcribe(coarse(checkout, name, axes))
    assert problem.separable.pieces is not None
    random, reference = np.random.default_rng(0), derivatives(problem.separable)
    w, task, multipliers = (random.uniform(0.1, 0.9, reference.numel_in(i)) for i in range(3))
    contacts = problem.layout.fractions.stop
    w[contacts:] = random.integers(0, 2, len(w) - contacts)
    functions = {
        each: casadi.Function(each, *arrays)
        for each, arrays in piecewise(problem.separable, problem.separable.pieces).items()
    }
    found = [
        *functions["problem"](w, task),
        functions["gradient"](w, task),
        functions["jacobian"](w, task),
        functions["hessian"](w, task, multipliers),
    ]
    names = ("cost", "rows", "gradient", "jacobian", "hessian")
    for which, mine, theirs in zip(names, found, reference(w, task, multipliers), strict=True):
        assert mine.nnz() == theirs.nnz() or (axes and mine.nnz() < 1.1 * theirs.nnz()), (
            "times of steps in later phases"
        )
        mine, theirs = mine.full(), theirs.full()
        np.testing.assert_allclose(mine, theirs, rtol=1e-11, atol=1e-13 * np.abs(theirs).max(), err_msg=which)
